"""Converts an official trajectory into a recording and reports how far it can be trusted.

The states are kept as they were written; re-simulation only measures how far our world drifts from them. The shapes
that hold the state before each action lack the last one: it is simulated when all before it agree, else the last
action is left out. The evaluator's shape lacks the first state: it is the map's own start.
"""

import hashlib
from dataclasses import asdict, dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Literal, cast, get_args

import numpy as np

from movingout.maps import MapSpec
from movingout.maps.spec import ARENA_HALF
from movingout.recordings.episode import (
    ROOM_PSEUDONYM,
    EpisodeHeader,
    Event,
    EventKind,
    Outcome,
    SeatInfo,
    SeatKind,
    TickRecord,
    is_room_pseudonym,
)
from movingout.recordings.errors import RecordingError
from movingout.recordings.file_format.journal import JOURNAL_SUFFIX, remove_left
from movingout.recordings.file_format.writer import EpisodeWriter
from movingout.recordings.imports.known_plays import KnownPlays, play_digest
from movingout.recordings.imports.map_match import official_map, played_map
from movingout.recordings.imports.sources import TrajectoryFile
from movingout.recordings.imports.steps import OfficialSteps, parse
from movingout.recordings.storage.finished import SUFFIX, finalise
from movingout.recordings.storage.listing import read_players, read_summary
from movingout.world import World
from movingout.world.constants import LIMIT_TICKS
from movingout.world.scoring import delivered_items
from movingout.world.state import Floats, WorldState

AGREE = 1e-9  # arena units or rad: what re-simulation may differ by and still count as the same
OTHER_PSEUDONYM = "P-"  # how names begin that hold for more than a room, as far as is known
PlayerKind = Literal["human", "agent"]  # what `--kind` may say
SOFTWARE = {"movingout": "imported", "pymunk": "of the official environment, version unknown"}


@dataclass(frozen=True, slots=True)
class ImportReport:
    """What is known about one imported trajectory."""

    file: str
    place: str
    shape: str
    map: str
    problem: str = ""  # why it was refused, empty when it was not
    unchanged: str = ""  # that it had been imported before, and as what; empty when it is new
    recording: str = ""  # name of the file made, empty when refused
    ticks: int = 0
    differences: tuple[str, ...] = ()  # from the map as designed
    varied: bool = False  # they are more than a hair: the episode counts for Challenge 2
    participants_known: bool = False  # else no participant-disjoint split can be made
    largest_magnitude: float = 0.0
    largest_angle: float = 0.0  # [rad], absolute
    outside: int = 0  # robot- and item-states outside the arena
    presses: int = 0  # grasp toggles
    idle_presses: int = 0  # without any effect
    unpressed_changes: int = 0  # holds that changed without a press
    inferred_holds: int = 0  # robot-states whose item was not named
    outcome: str = ""
    outcome_known: bool = False  # the file says the same; else delivered, time or stopped, by the states and the limit
    limit_ticks: int = 0
    last_tick: str = ""  # "recorded", "simulated" or "left out"
    drift: float = 0.0  # largest distance between recorded and re-simulated positions
    drift_tick: int = -1  # first tick that differs by more than 1e-9, -1 for none

    def to_json(self) -> dict[str, Any]:
        return asdict(self)


def import_source(
    source: TrajectoryFile,
    folder: Path,
    salt: str,
    kind: str = "",
    known: KnownPlays | None = None,
    limit_ticks: int = LIMIT_TICKS,
) -> ImportReport:
    """Write one trajectory into `folder`. Never raises for what is in it: the report says why it was refused.

    `kind` is who played, "human" or "agent"; without it what the file says, or its shape suggests. What is `known`
    (`known_plays`) is not written again. `limit_ticks`: after how many ticks an episode was out of time, where the file
    does not say it.
    """
    source = _limited(_played_by(source, kind), limit_ticks)
    try:
        return _import(source, folder, salt, known or {})
    except RecordingError as error:
        problem = str(error)
    except (ValueError, TypeError, OverflowError, KeyError, IndexError) as error:  # one trajectory of many
        problem = f"something in it is not as the official files have it ({type(error).__name__}: {error})"
    return ImportReport(*_origin(source), map=str(source.map_name), problem=problem)


def names_people(source: TrajectoryFile, kind: str = "") -> bool:
    """Whether it has people's names, of which our own exports have pseudonyms; `kind` as for `import_source`."""
    seats = zip(_kinds(_played_by(source, kind)), (source.blue, source.red), strict=True)
    return not any(source.kinds) and any(kind == "human" and name for kind, name in seats)


def pseudonym(name: str, salt: str) -> str:
    """A pseudonym, the same for the same name; it leads back to the name only for those who know the salt.

    It also says whether the name held for one room only.
    """
    digest = hashlib.sha256("\n".join((salt, name)).encode()).hexdigest()
    prefix = ROOM_PSEUDONYM if is_room_pseudonym(name) else OTHER_PSEUDONYM
    return f"{prefix}{digest[:8]}" if name else ""


def _import(source: TrajectoryFile, folder: Path, salt: str, known: KnownPlays) -> ImportReport:
    steps = parse(source.steps)
    designed = official_map(source.map_name)
    before = source.shape != "evaluator"
    played, differences = played_map(designed, steps, starts=before, masses=source.masses)
    spec = played if played.variant else designed
    states, actions = _aligned(played, steps, before)
    simulated = _simulated(played, actions)
    drift_tick, drift = _drift(states, simulated)
    last = "recorded"
    if before:
        states, actions, last = _completed(states, actions, simulated, agrees=drift_tick < 0)
    if played != spec:  # as whoever simulates the recording will find
        drift_tick, drift = _drift(states, _simulated(spec, actions))
    if not len(actions):
        raise RecordingError("there is no tick with a state before and after it")
    header = _header(source, salt, spec)
    path = folder / f"{header.episode_id}{SUFFIX}"
    there = _made_before(path, known.get(_digest(spec, steps, before)))
    unchanged = _known(there, header, path) if there else ""
    outcome = _outcome(source, delivered_items(spec, states[-1].item_poses).tolist(), len(actions))
    path = there or _written(source, folder, header, states, actions, outcome)
    return ImportReport(
        *_origin(source),
        map=spec.name,
        recording=path.name,
        unchanged=unchanged,
        ticks=len(actions),
        differences=tuple(differences),
        varied=bool(read_summary(there).variant if there else spec.variant),
        participants_known=all(seat.name for seat in (read_players(there).seats if there else header.seats)),
        **_checks(states, actions, steps),
        outcome=outcome,
        outcome_known=outcome == source.outcome,
        limit_ticks=source.limit_ticks,
        last_tick=last,
        drift=drift,
        drift_tick=drift_tick,
    )


def _completed(
    states: list[WorldState], actions: Floats, simulated: list[WorldState], *, agrees: bool
) -> tuple[list[WorldState], Floats, str]:
    """States and actions of a file that has no state after its last action, and what became of that tick.

    Its state is simulated where the simulation agrees with all states before; otherwise the tick is left out.
    """
    if agrees:
        return [*states, simulated[len(states)]], actions, "simulated"
    return states, actions[:-1], "left out"


def _origin(source: TrajectoryFile) -> tuple[str, str, str]:
    return source.file.name, source.place, source.shape


def _aligned(spec: MapSpec, steps: OfficialSteps, before: bool) -> tuple[list[WorldState], Floats]:
    """States and actions so that action k leads from state k to state k + 1, as far as states are known."""
    first = 0 if before else 1
    states = [
        WorldState(
            tick=first + k,
            robot_poses=steps.robot_poses[k],
            robot_velocities=steps.robot_velocities[k],
            held=steps.held[k],
            item_poses=steps.item_poses[k],
        )
        for k in range(len(steps.actions))
    ]
    return (states if before else [World(spec).state(), *states]), steps.actions


def _simulated(spec: MapSpec, actions: Floats) -> list[WorldState]:
    world = World(spec, record_sub_poses=False)
    simulated = [world.state()]
    for action in actions:
        world.step(action)
        simulated.append(world.state())
    return simulated


def _drift(states: list[WorldState], simulated: list[WorldState]) -> tuple[int, float]:
    """The first tick that differs, -1 for none, and the largest distance."""
    first, largest = -1, 0.0
    for recorded, ours in zip(states, simulated, strict=False):
        robots = recorded.robot_poses - ours.robot_poses
        items = recorded.item_poses - ours.item_poses
        largest = max(largest, float(np.abs(robots[:, :2]).max()), float(np.abs(items[:, :2]).max()))
        differs = max(np.abs(robots).max(), np.abs(items).max()) > AGREE or not np.array_equal(recorded.held, ours.held)
        if differs and first < 0:
            first = recorded.tick
    return first, largest


def _checks(states: list[WorldState], actions: Floats, steps: OfficialSteps) -> dict[str, Any]:
    held = np.array([state.held for state in states])
    changed = held[1:] != held[:-1]
    pressed = actions[..., 2] > 0.5
    places = [np.concatenate([state.robot_poses, state.item_poses])[:, :2] for state in states]
    return {
        "largest_magnitude": float(np.abs(actions[..., 0]).max()),
        "largest_angle": float(np.abs(actions[..., 1]).max()),
        "outside": int(sum((np.abs(place) > ARENA_HALF).any(axis=1).sum() for place in places)),
        "presses": int(pressed.sum()),
        "idle_presses": int((pressed & ~changed).sum()),
        "unpressed_changes": int((changed & ~pressed).sum()),
        "inferred_holds": steps.inferred_holds,
    }


def _digest(spec: MapSpec, steps: OfficialSteps, before: bool) -> str:
    """What `known_plays` has of the same play; empty where the poses before the last action are not known."""
    last = len(steps.actions) - (1 if before else 2)
    return play_digest(spec.name, steps.actions, steps.robot_poses[last], steps.item_poses[last]) if last >= 0 else ""


def _made_before(path: Path, alike: Path | None) -> Path | None:
    """The recording of the same play: the own one, or one that is `alike`. An import that was cut off is none."""
    if path.exists() and read_summary(path).complete:
        return path
    return None if alike == path else alike


def _known(path: Path, header: EpisodeHeader, own: Path) -> str:
    """What to say of a trajectory whose recording is there already, as `own` or under another name: it is kept."""
    kept, seats = read_players(path).seats, header.seats
    said = "imported before" if path == own else f"recorded already, as {path.name}"
    otherwise = f"To import it otherwise, move {path.name} away"
    if [seat.kind for seat in kept] != [seat.kind for seat in seats]:
        return f"{said}, with {kept[0].kind} in blue and {kept[1].kind} in red; nothing changed. {otherwise}"
    if read_summary(path).variant and not header.map.variant:
        return f"{said}, on a varied map; nothing changed. To count it as designed, import it into a new folder"
    if any(new.name and not old.name for old, new in zip(kept, seats, strict=True)):
        return f"{said}, without names; nothing changed. To name its participants, import it into a new folder"
    given = [(old.name, new.name) for old, new in zip(kept, seats, strict=True) if new.name]
    if path == own and any(_without_prefix(old) != _without_prefix(new) for old, new in given):
        return f"{said}, with other names (or another --salt); nothing changed. {otherwise}"
    return f"{said}; nothing changed"


def _without_prefix(pseudonym: str) -> str:
    """The id without its prefix: at first, names of one room had the same prefix as all others."""
    return pseudonym.removeprefix(ROOM_PSEUDONYM).removeprefix(OTHER_PSEUDONYM)


def _written(
    source: TrajectoryFile,
    folder: Path,
    header: EpisodeHeader,
    states: list[WorldState],
    actions: Floats,
    outcome: Outcome,
) -> Path:
    spec, started, kinds = header.map, header.started_ns, _kinds(source)
    remove_left(folder / f"{header.episode_id}{JOURNAL_SUFFIX}")
    (folder / f"{header.episode_id}{SUFFIX}").unlink(missing_ok=True)  # of an import that was cut off
    writer = EpisodeWriter.create(folder, header, states[0], clock=lambda: started, software=SOFTWARE)
    delivered = tuple(delivered_items(spec, states[0].item_poses).tolist())
    for before, action, after in zip(states, actions, states[1:], strict=False):
        now = tuple(delivered_items(spec, after.item_poses).tolist())
        for event in _events(before, after, delivered, now):
            writer.event(event)
        writer.tick(TickRecord(action, kinds, (-1, -1), after, now, 0.0))
        delivered = now
    return finalise(writer.close(outcome))


def _header(source: TrajectoryFile, salt: str, spec: MapSpec) -> EpisodeHeader:
    names = zip(_kinds(source), (source.blue, source.red), strict=True)
    blue, red = (SeatInfo(kind, pseudonym(name, salt) if kind == "human" else name) for kind, name in names)
    return EpisodeHeader(
        episode_id=f"import-{spec.name}-{source.id}",
        map=spec,
        seed=0,
        limit_ticks=source.limit_ticks,
        seats=(blue, red),
        started_ns=_started(source),
        source="import",
        study={"imported_from": source.file.name, "shape": source.shape}
        | ({"simulated": "yes"} if source.simulated else {}),
    )


def _played_by(source: TrajectoryFile, kind: str) -> TrajectoryFile:
    return replace(source, kinds=(kind, kind)) if kind else source


def _limited(source: TrajectoryFile, limit_ticks: int) -> TrajectoryFile:
    return source if source.limit_ticks else replace(source, limit_ticks=limit_ticks)


def _kinds(source: TrajectoryFile) -> tuple[SeatKind, SeatKind]:
    """Who played blue and red: as the file says, else agents in the evaluator's shape and people in the others."""
    usual: SeatKind = "agent" if source.shape == "evaluator" else "human"
    blue, red = (known if known in get_args(SeatKind) else usual for known in source.kinds)
    return cast(SeatKind, blue), cast(SeatKind, red)


def _started(source: TrajectoryFile) -> int:
    """The recorder's time (taken as UTC), else the file's modification time; a recording holds times up to 2262."""
    try:
        moment = datetime.strptime(source.time, "%Y-%m-%d_%H:%M:%S").replace(tzinfo=UTC)
    except ValueError:
        return source.recorded_ns
    started = int(moment.timestamp()) * 1_000_000_000
    return started if 0 <= started < 1 << 63 else source.recorded_ns


def _events(before: WorldState, after: WorldState, was: tuple[bool, ...], now: tuple[bool, ...]) -> list[Event]:
    """Grabs, releases and deliveries, as the states show them."""
    found: list[Event] = []
    for seat, (held, holds) in enumerate(zip(before.held.tolist(), after.held.tolist(), strict=True)):
        if held != holds and held >= 0:
            found.append(Event(after.tick, "release", seat, held))
        if held != holds and holds >= 0:
            found.append(Event(after.tick, "grab", seat, holds))
    for item, (then, later) in enumerate(zip(was, now, strict=True)):
        if then != later:
            kind: EventKind = "delivered" if later else "undelivered"
            found.append(Event(after.tick, kind, item=item))
    return found


def _outcome(source: TrajectoryFile, delivered: list[bool], ticks: int) -> Outcome:
    """How it ended, as the states show it or the file says; the last action may have been left out."""
    if all(delivered):
        return "delivered"
    if source.outcome is not None:
        return "stopped" if source.outcome == "delivered" else source.outcome
    return "time" if ticks >= source.limit_ticks - 1 else "stopped"
