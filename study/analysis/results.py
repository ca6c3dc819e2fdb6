"""The contents of a study's store, arranged for analysis: valid rounds, newest answers, participant flow."""

from collections import Counter, defaultdict
from collections.abc import Container, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from pathlib import Path
from typing import Any

from movingout.recordings.episode import FINISHED
from movingout.recordings.report.words import Phrase
from movingout.study.analysis.cells import CellValue, CellValues, Means, Paired, name_cells, paired
from movingout.study.analysis.pings import PingRound, ping_rounds
from movingout.study.analysis.questions import ABOUT_NOBODY, RATED, Occasion, occasion
from movingout.study.analysis.sessions import Sessions, sessions_of
from movingout.study.design.allocation import letters
from movingout.study.design.definition import SUBSTITUTE, Study
from movingout.study.design.pooling import pooled_blocks
from movingout.study.questionnaire import NO_ANSWER
from movingout.study.store.removal import undecided
from movingout.study.store.rounds import UNPLAYED
from movingout.study.store.store import Store
from movingout.study.store.tables import answers, counts, participants, players, rounds, tombstones, units
from movingout.world.metrics import METRICS

STORED = tuple(metric for metric in METRICS if metric.key in rounds.c)  # what the table of rounds has a column for
AWAY_SHARE = 0.5  # of ticks without input
HIDDEN_S = 2.0
RECENT_MS = 86_400_000  # whoever was there within a day may still be taking part
Row = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Flag:
    """A reason to check a round or a participant before trusting the data."""

    pid: str
    step: str
    reason: Phrase


@dataclass(frozen=True, slots=True)
class Results:
    """Everything that the report shows, before statistics."""

    study: Study
    flow: tuple[tuple[str, int], ...]  # stage (a key of the report's sentences) and how many
    rounds: tuple[Row, ...]  # that count, in the order played
    people: dict[int, tuple[str, ...]]  # unit to participants
    answers: tuple[Row, ...]  # the newest, without those about rounds that do not count
    flags: tuple[Flag, ...]
    pings: tuple[PingRound, ...] = ()  # of rounds that count, in blocks with pings; two of each round
    sessions: Sessions = field(default_factory=Sessions)  # of rounds that count, with agents
    blinded: bool = False  # whether nothing shown may tell which partner is which agent

    @property
    def partners(self) -> tuple[str, ...]:
        """The partners played with, in the order of the study file, or of their letters; "" is another participant."""
        return self._in_order({row["partner"] for row in self.rounds})

    @property
    def rated_partners(self) -> tuple[str, ...]:
        """The same, and those of whom only answers count: what was said of a partner stays when no round does."""
        said = {row["partner"] for row in self.answers if occasion(row["step"]) not in ABOUT_NOBODY}
        return self._in_order({*self.partners, *said})

    def _in_order(self, met: Container[str]) -> tuple[str, ...]:
        planned = [one.id for one in self.study.partners]
        if self.blinded:
            planned.sort(key=list(letters(self.study)).index)
        known = dict.fromkeys((*planned, SUBSTITUTE, ""))
        return tuple(name for name in known if name in met)

    @property
    def maps(self) -> tuple[str, ...]:
        met = {row["map"] for row in self.rounds}
        return tuple(dict.fromkeys(name for block in self.study.blocks for name in block.maps if name in met))

    def values(self, metric: str, partner: str, map_name: str | None = None) -> list[float]:
        """A metric of each round with a partner, of one map or of all."""
        return [
            row[metric]
            for row in self.rounds
            if row["partner"] == partner and map_name in (None, row["map"]) and row[metric] is not None
        ]

    def compare_rounds(self, metric: str, one: str, other: str) -> Paired:
        """A metric with two partners: the means of each participant (or pair) over what they have of both."""
        return paired(*(self._by_unit(metric, partner) for partner in (one, other)))

    def _by_unit(self, metric: str, partner: str) -> CellValues:
        found: CellValues = defaultdict(list)
        for row in self.rounds:
            if row["partner"] == partner:
                found[str(row["unit"])].append(CellValue(row["cell"], row[metric], row["episode"]))
        return dict(found)

    def ratings(
        self, questionnaire: str, item: str, partner: str | None, occasions: Container[Occasion] = RATED
    ) -> dict[str, float]:
        """The mean rating of each participant, where there is one; without a partner, what was said at the end."""
        found: dict[str, list[float]] = defaultdict(list)
        for row in self._said(questionnaire, item, partner, occasions):
            if row["value"] != NO_ANSWER:
                found[row["pid"]].append(float(row["value"]))
        return {pid: sum(values) / len(values) for pid, values in found.items()}

    def compare_ratings(
        self, questionnaire: str, item: str, one: str, other: str, occasions: Container[Occasion] = RATED
    ) -> Paired:
        """An item with two partners: the mean ratings of each participant or pair over what they rated of both.

        What the two of a pair say of each other is not independent.
        """
        found = paired(*(self._by_pid(questionnaire, item, partner, occasions) for partner in (one, other)))
        return Paired(self._unit_means(found.first), self._unit_means(found.second), found.left_out)

    def _unit_means(self, by_pid: Means) -> Means:
        found = {str(unit): [by_pid[pid] for pid in pids if pid in by_pid] for unit, pids in self.people.items()}
        return {unit: sum(values) / len(values) for unit, values in found.items() if values}

    def _by_pid(self, questionnaire: str, item: str, partner: str, occasions: Container[Occasion]) -> CellValues:
        found: CellValues = defaultdict(list)
        for row in self._said(questionnaire, item, partner, occasions):
            value = None if row["value"] == NO_ANSWER else float(row["value"])
            found[row["pid"]].append(CellValue(row.get("cell", ""), value, f"{row['step']}/{item}"))
        return dict(found)

    def counts(
        self, questionnaire: str, item: str, partner: str | None, occasions: Container[Occasion]
    ) -> Counter[int]:
        """How often each value was answered, NO_ANSWER too."""
        return Counter(row["value"] for row in self._said(questionnaire, item, partner, occasions))

    def _said(
        self, questionnaire: str, item: str, partner: str | None, occasions: Container[Occasion]
    ) -> Iterator[Row]:
        for row in self.answers:
            when = occasion(row["step"])
            about = None if when in ABOUT_NOBODY else row["partner"]
            asked = (row["questionnaire"], row["item"], about) == (questionnaire, item, partner)
            if asked and when in occasions:
                yield row

    def by_condition(self) -> tuple[tuple[str, "Results"], ...]:
        """The blocks that may be pooled, by name, with their rounds and answers; all, without a name, where all may."""
        pooled = pooled_blocks(self.study)
        if len(pooled) == 1:
            return (("", self),)
        return tuple((", ".join(blocks), self._of_blocks(blocks)) for blocks in pooled)

    def by_condition_asked(self) -> tuple[tuple[str, "Results"], ...]:
        """The same for answers: where blocks stay apart, so do the questions before and after all of them."""
        blocks = self.by_condition()
        said = tuple(row for row in self.answers if occasion(row["step"]) in ABOUT_NOBODY)
        return blocks if len(blocks) == 1 else (*blocks, ("", replace(self, rounds=(), answers=said)))

    def _of_blocks(self, blocks: Container[str]) -> "Results":
        said = [row for row in self.answers if occasion(row["step"]) not in ABOUT_NOBODY]
        return replace(
            self,
            sessions=self.sessions.of_blocks(blocks),
            rounds=tuple(row for row in self.rounds if row["block"] in blocks),
            answers=tuple(row for row in said if row["step"].partition("/")[0] in blocks),
            pings=tuple(one for one in self.pings if one.block in blocks),
        )

    def texts(self) -> list[Row]:
        return [row for row in self.answers if row["text"].strip()]


def collect(study: Study, store: Store, recordings: Path, annotations: Sequence[Path] = ()) -> Results:
    """Read a store, and its recordings: where there are pings in them, and where partners may have failed.

    `annotations` are files of verdicts besides the one beside the recordings. Rounds and answers of participants who
    did not want their data kept are left out.
    """
    waiting = undecided(store)
    people = [row for row in store.rows(participants) if row["pid"] not in waiting]
    refused = {row["pid"] for row in people if row["keep"] is False}
    left_out = {row["unit"] for row in people if row["pid"] in refused}
    kept = [row for row in store.rows(rounds) if row["unit"] not in left_out]
    newest = {(row["pid"], row["step"], row["item"]): row for row in store.rows(answers) if row["pid"] not in refused}
    groups: dict[int, list[str]] = defaultdict(list)
    for row in sorted(people, key=lambda row: row["member"]):
        if row["unit"] is not None:
            groups[row["unit"]].append(row["pid"])
    _name_substitutes(study, kept, newest.values(), groups)
    counted = tuple(row for row in kept if row["valid"] and row["outcome"] in FINISHED)
    said = tuple(_about_what_counts(newest.values(), kept, counted, groups))
    _name_cells(study, store, counted, said, groups)
    found = Results(
        study=study,
        flow=tuple(_flow(study, store, people, len(refused))),
        rounds=counted,
        people={unit: tuple(pids) for unit, pids in groups.items()},
        answers=said,
        flags=(*_round_flags(study, store, kept), *_attention_flags(study, newest.values())),
        pings=ping_rounds(study, counted, store.rows(players), recordings),
        sessions=sessions_of(counted, store.rows(players), recordings, annotations, pooled_blocks(study)),
    )
    about_partners = (*_fault_flags(found), *_unpaired_flags(found, _under_way(store, people)))
    return replace(found, flags=(*found.flags, *about_partners))


def _name_substitutes(study: Study, kept: list[Row], said: Iterable[Row], groups: dict[int, list[str]]) -> None:
    """Fill in, where earlier versions did not, the partner of a round and of its questions in a unit of one."""
    played = {row["unit"] for row in kept}  # with a member who was deleted, the rounds of a pair went, too
    alone = {pids[0] for unit, pids in groups.items() if study.group == 2 and len(pids) == 1 and unit in played}
    units_alone = {unit for unit, pids in groups.items() if pids[0] in alone}
    blocks = {block.id for block in study.blocks}
    for row in kept:
        if row["unit"] in units_alone:
            row["partner"] = row["partner"] or SUBSTITUTE
    for row in said:
        if row["pid"] in alone and row["step"].partition("/")[0] in blocks:
            row["partner"] = row["partner"] or SUBSTITUTE


def _about_what_counts(
    said: Iterable[Row], kept: Iterable[Row], counted: Iterable[Row], groups: dict[int, list[str]]
) -> Iterator[Row]:
    """Drop answers about rounds that do not count; those about a partner stay: they are about other rounds, too."""
    units = {pid: unit for unit, pids in groups.items() for pid in pids}
    played, valid = ({(row["unit"], row["step"]) for row in rows} for rows in (kept, counted))
    for row in said:
        about = units.get(row["pid"]), row["step"].rpartition("/")[0]
        if about not in played or about in valid:
            yield row


def _name_cells(
    study: Study, store: Store, counted: Sequence[Row], said: Sequence[Row], groups: dict[int, list[str]]
) -> None:
    seats = {(row["round"], row["pid"]): row["seat"] for row in store.rows(players)}
    for row in counted:
        first = groups[row["unit"]][0] if groups.get(row["unit"]) else ""
        row["seat"] = seats.get((row["id"], first))
    name_cells(study, counted, said, {pid: unit for unit, pids in groups.items() for pid in pids})


def _flow(study: Study, store: Store, people: list[Row], refused: int) -> Iterable[tuple[str, int]]:
    """The flow of participants, as in a CONSORT diagram."""
    outcomes = [row["outcome"] for row in people]
    declined = next((row["number"] for row in store.rows(counts) if row["name"] == "declined"), 0)
    removed = len(store.rows(tombstones))
    yield "came", len(people) + declined + removed
    yield "declined", declined
    yield "deleted", removed
    yield "allocated", sum(row["unit"] is not None for row in people)
    for outcome in ("screened-out", "no-partner", "partner-left", "withdrew", "dropped-out"):
        yield outcome, outcomes.count(outcome)
    yield "open", outcomes.count(None)
    yield "finished", outcomes.count("done")
    yield "unwanted", refused
    size = Counter(row["unit"] for row in people)
    yield "complete", sum(row["state"] == "done" and size[row["id"]] == study.group for row in store.rows(units))


def _round_flags(study: Study, store: Store, kept: list[Row]) -> Iterable[Flag]:
    by_number = {row["id"]: row for row in kept}
    for row in kept:
        if row["episode"].startswith(UNPLAYED) and not row["valid"]:
            yield Flag("", row["step"], Phrase("study.flag.unplayed", {"unit": row["unit"]}))
        elif not row["valid"]:
            yield Flag("", row["step"], Phrase("study.flag.invalid", {"unit": row["unit"]}))
        elif row["outcome"] not in FINISHED:
            why = Phrase(f"recordings.outcome.{row['outcome']}" if row["outcome"] else "study.flag.open")
            how = {"unit": row["unit"], "outcome": why}
            yield Flag("", row["step"], Phrase("study.flag.unfinished", how))
    yield from _one_screen_flags(store, {row["unit"] for row in kept})
    for one in store.rows(players):
        step = by_number[one["round"]]["step"] if one["round"] in by_number else None
        if step is None:
            continue
        if (one["idle_share"] or 0.0) > AWAY_SHARE:
            yield Flag(one["pid"], step, Phrase("study.flag.idle", {"percent": f"{100 * one['idle_share']:.0f}"}))
        if (one["hidden_s"] or 0.0) > HIDDEN_S:
            yield Flag(one["pid"], step, Phrase("study.flag.hidden", {"seconds": f"{one['hidden_s']:.0f}"}))
        if (one["rtt_ms"] or 0.0) > study.gate.rtt_ms:
            yield Flag(one["pid"], step, Phrase("study.flag.rtt", {"ms": f"{one['rtt_ms']:.0f}"}))


def _fault_flags(results: Results) -> Iterable[Flag]:
    """Rounds in which the agent had a fault: one that could not begin, as where it is too slow, never moves."""
    at_fault = {one.id for one in results.sessions.recordings if one.agent_errors}
    for row in results.rounds:
        if row["episode"] in at_fault:
            yield Flag("", row["step"], Phrase("study.flag.fault", {"unit": row["unit"]}))


def _one_screen_flags(store: Store, played: Container[int]) -> Iterable[Flag]:
    """Pairs at one screen: they see and hear each other, and nothing shows that they really were two people."""
    pairs = Counter((row["unit"], row["screen"]) for row in store.rows(participants) if row["screen"])
    for unit in sorted(unit for (unit, _), people in pairs.items() if people > 1 and unit in played):
        yield Flag("", "–", Phrase("study.flag.one_screen", {"unit": unit}))


def _unpaired_flags(results: Results, under_way: Container[int]) -> Iterable[Flag]:
    """Whose rounds are missing where partners are compared: the other partner has none that count on the same map.

    Those `under_way` may still play them.
    """
    for label, part in results.by_condition():
        left_out: set[tuple[str, str]] = set()
        for one, other in combinations(part.partners, 2):
            left_out |= part.compare_rounds("tcr", one, other).left_out
        played = Counter(row["unit"] for row in part.rounds)
        for unit, number in sorted(Counter(int(unit) for unit, _ in left_out).items()):
            if unit not in under_way:
                values = {"unit": unit, "number": number, "all": played[unit]}
                yield Flag("", label or "–", Phrase("study.flag.unpaired", values))


def _under_way(store: Store, people: Iterable[Row]) -> set[int]:
    """Units that have not ended and have a member heard from within a day; one who leaves alone does not end a unit."""
    since = store.now() - RECENT_MS
    here = {row["unit"] for row in people if max(row["arrived_ms"], row["heard_ms"] or 0) >= since}
    return {row["id"] for row in store.rows(units) if row["state"] == "active" and row["id"] in here}


def _attention_flags(study: Study, newest: Iterable[Row]) -> Iterable[Flag]:
    for row in newest:
        expected = study.questionnaire(row["questionnaire"]).item(row["item"]).expected
        if expected is not None and row["value"] != expected:
            key = "study.flag.attention.unanswered" if row["value"] == NO_ANSWER else "study.flag.attention"
            answer = {"item": row["item"], "value": row["value"], "expected": expected}
            yield Flag(row["pid"], row["step"], Phrase(key, answer))
