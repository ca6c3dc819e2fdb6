"""The rounds of a study: one row per recording, opened before the first tick and closed after the last."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace

from sqlalchemy import ColumnElement, Connection, func, insert, select, update

from movingout.recordings.episode import FINISHED
from movingout.study.design.steps import CARD_S, Step, partner_met
from movingout.study.errors import StudyError
from movingout.study.store.audit import record
from movingout.study.store.store import Store, Unit
from movingout.study.store.tables import consents, players, rounds
from movingout.world.constants import TICK_SECONDS

UNPLAYED = "unplayed-"  # begins what stands for the recording of a round that was left out
LONGEST_PAUSE_S = 300.0  # of one pause, what counts as time in a block


@dataclass(frozen=True, slots=True)
class RoundOutcome:
    """How a round went; `ac` is None where nothing was carried together."""

    outcome: str  # delivered, time, left, stopped, error or interrupted
    ticks: int
    tcr: float
    nfd: float
    wt_s: float
    ac: float | None
    late_ms: float | None = None  # 99th percentile


@dataclass(frozen=True, slots=True)
class PlayerOutcome:
    """How a round went for one participant."""

    pid: str
    seat: int
    device: str  # empty at the start: that of the last round; at the end, where nothing was pressed: it stays
    rtt_ms: float | None = None  # median
    idle_share: float | None = None
    hidden_s: float | None = None


@dataclass(frozen=True, slots=True)
class LastRound:
    """The newest round of a unit that was played to its end."""

    episode: str
    step: str
    map: str
    valid: bool


class Rounds:
    """Opens and closes rounds in a store."""

    def __init__(self, store: Store) -> None:
        self._store = store

    def begin(self, unit: Unit, step: Step, episode: str, seated: Sequence[PlayerOutcome]) -> int:
        """Open a round; returns the number of the attempt. Raises StudyError where a consent is missing."""
        with self._store.database.write() as connection:
            for one in seated:
                if not connection.execute(select(consents.c.id).where(consents.c.pid == one.pid)).first():
                    raise StudyError("no tick is played before everybody has consented")
            return self._add(connection, unit, step, seated, episode=episode, valid=True)

    def _add(
        self, connection: Connection, unit: Unit, step: Step, seated: Sequence[PlayerOutcome], **values: object
    ) -> int:
        """Add a round; returns the number of the attempt."""
        if step.turn is None:
            raise StudyError(f"step {step.key} is not a round")
        mine = select(func.count()).select_from(rounds).where(rounds.c.unit == unit.id)
        attempt = connection.execute(mine.where(rounds.c.step == step.key)).scalar_one() + 1
        row = {"unit": unit.id, "step": step.key, "attempt": attempt, "block": step.block}
        row["partner"] = partner_met(step, len(unit.pids))
        row |= {"map": step.turn.map, "variant_seed": step.turn.variant_seed, "limit_ticks": step.limit_ticks}
        row |= {"position": connection.execute(mine).scalar_one() + 1, "started_ms": self._store.now(), **values}
        number = connection.execute(insert(rounds).values(**row).returning(rounds.c.id)).scalar_one()
        known = [one if one.device else replace(one, device=_last_device(connection, one.pid)) for one in seated]
        connection.execute(insert(players), [{"round": number, **asdict(one)} for one in known])
        return int(attempt)

    def leave_out(self, unit: Unit, step: Step, seated: Sequence[PlayerOutcome]) -> None:
        """Add a round that cannot be played, once: invalid, without a tick and a recording.

        Raises StudyError for a step that is no round.
        """
        with self._store.database.write() as connection:
            mine = rounds.c.unit == unit.id
            episode = f"{UNPLAYED}{unit.id}-{connection.execute(select(func.count()).where(mine)).scalar_one() + 1}"
            same = rounds.c.step == step.key, rounds.c.episode.startswith(UNPLAYED)
            if connection.execute(select(rounds.c.id).where(mine, *same)).first():
                return
            outcome = asdict(RoundOutcome("error", 0, 0.0, 0.0, 0.0, None))
            self._add(
                connection, unit, step, seated, episode=episode, valid=False, ended_ms=self._store.now(), **outcome
            )
            record(connection, self._store.now(), "server", "skip-round", step=step.key)

    def end(
        self, episode: str, played: RoundOutcome, seated: Sequence[PlayerOutcome] = (), recovered: bool = False
    ) -> None:
        """Close a round with its outcome; one that is `recovered`, after its last tick, ended about then, not now.

        Raises StudyError for a recording of no round.
        """
        with self._store.database.write() as connection:
            find = select(rounds.c.id, rounds.c.started_ms).where(rounds.c.episode == episode)
            opened = connection.execute(find).one_or_none()
            if opened is None:
                raise StudyError(f"there is no round with the recording {episode!r}")
            number, ended = opened.id, self._store.now()
            if recovered:
                ended = min(ended, opened.started_ms + round(1e3 * (CARD_S + played.ticks * TICK_SECONDS)))
            change = update(rounds).where(rounds.c.id == number)
            connection.execute(change.values(**asdict(played), ended_ms=ended))
            for one in seated:
                here = update(players).where(players.c.round == number, players.c.pid == one.pid)
                known = {name: value for name, value in asdict(one).items() if value not in (None, "")}
                connection.execute(here.values(**known))

    def finished_steps(self, unit: int) -> frozenset[str]:
        """The keys of finished, valid rounds."""
        query = select(rounds.c.step).where(rounds.c.unit == unit, rounds.c.valid)
        with self._store.database.read() as connection:
            return frozenset(connection.execute(query.where(rounds.c.outcome.in_(FINISHED))).scalars())

    def all_finished_steps(self) -> Mapping[int, frozenset[str]]:
        """The same by unit, of all units that have any, in one query."""
        return self._steps_of_units(rounds.c.valid, rounds.c.outcome.in_(FINISHED))

    def all_left_out(self) -> Mapping[int, frozenset[str]]:
        """The keys of rounds that could not be played, by unit."""
        return self._steps_of_units(rounds.c.episode.startswith(UNPLAYED))

    def _steps_of_units(self, *which: ColumnElement[bool]) -> Mapping[int, frozenset[str]]:
        found: dict[int, set[str]] = {}
        with self._store.database.read() as connection:
            for row in connection.execute(select(rounds.c.unit, rounds.c.step).where(*which)):
                found.setdefault(row.unit, set()).add(row.step)
        return {unit: frozenset(steps) for unit, steps in found.items()}

    def block_seconds(self, unit: int) -> dict[str, float]:
        """Seconds that each block has lasted, its rounds and what lay between them.

        Of a pause or an absence only the first minutes count: the time of a block is for playing. Rounds go as they
        were played: where the clock was set back, by their times they do not.
        """
        mine = rounds.c.unit == unit, rounds.c.ended_ms.is_not(None)
        columns = rounds.c.block, rounds.c.started_ms, rounds.c.ended_ms, rounds.c.ticks
        query = select(*columns).where(*mine).order_by(rounds.c.id)
        lasted: dict[str, float] = {}
        ended: dict[str, int] = {}
        with self._store.database.read() as connection:
            for row in connection.execute(query):
                between = (row.started_ms - ended.get(row.block, row.started_ms)) / 1e3
                most = LONGEST_PAUSE_S + (row.ticks or 0) * TICK_SECONDS
                played = min((row.ended_ms - row.started_ms) / 1e3, most)
                spent = max(0.0, min(between, LONGEST_PAUSE_S)) + max(0.0, played)
                lasted[row.block] = lasted.get(row.block, 0.0) + spent
                ended[row.block] = row.ended_ms
        return lasted

    def newest_episodes(self) -> Mapping[int, str]:
        """The recording of each unit's newest round."""
        query = select(rounds.c.unit, rounds.c.episode).order_by(rounds.c.id)
        with self._store.database.read() as connection:
            return {row.unit: row.episode for row in connection.execute(query)}

    def last_finished(self, unit: int | None = None) -> Mapping[int, LastRound]:
        """The newest finished round of each unit, or of one, marked invalid or not."""
        columns = rounds.c.unit, rounds.c.episode, rounds.c.step, rounds.c.map, rounds.c.valid
        query = select(*columns).where(rounds.c.outcome.in_(FINISHED)).order_by(rounds.c.id)
        if unit is not None:
            query = query.where(rounds.c.unit == unit)
        with self._store.database.read() as connection:
            return {row.unit: LastRound(row.episode, row.step, row.map, row.valid) for row in connection.execute(query)}

    def open_episodes(self) -> Mapping[str, int]:
        """Rounds that a killed server left open: recordings with their units."""
        query = select(rounds.c.episode, rounds.c.unit).where(rounds.c.ended_ms.is_(None))
        with self._store.database.read() as connection:
            return {row.episode: row.unit for row in connection.execute(query)}

    def mark(self, episode: str, valid: bool) -> int:
        """Mark a round as valid or invalid for the experimenter, and return the unit that played it.

        Raises StudyError for a recording of no round.
        """
        with self._store.database.write() as connection:
            change = update(rounds).where(rounds.c.episode == episode).values(valid=valid).returning(rounds.c.unit)
            unit = connection.execute(change).scalar()
            if unit is None:
                raise StudyError(f"there is no round with the recording {episode!r}")
            record(connection, self._store.now(), "experimenter", "mark", episode=episode, valid=valid)
            return int(unit)


def _last_device(connection: Connection, pid: str) -> str:
    """What somebody played with in their last round; empty where nothing is known."""
    mine = players.c.pid == pid, players.c.device != ""
    query = select(players.c.device).where(*mine).order_by(players.c.round.desc()).limit(1)
    return connection.execute(query).scalar() or ""
