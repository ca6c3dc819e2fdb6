"""The tables of a report; each is part of the page and a CSV file."""

from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import combinations
from pathlib import Path

from movingout.recordings.pings import FOLLOWED_WITHIN_S, NEAR
from movingout.recordings.report.words import Words
from movingout.study.analysis.comparisons import PartnerComparison, compare, corrected, trend
from movingout.study.analysis.pings import PingRound
from movingout.study.analysis.results import STORED, Results
from movingout.study.design.steps import AT_END
from movingout.world.estimates import estimate, estimate_text
from movingout.world.ping import OWN_PLACE

HEADS = {metric.key: f"{metric.heading} {'↑' if metric.higher_is_better else '↓'}" for metric in STORED}
LANGUAGE_FILES = Path(__file__).with_name("languages")
ENGLISH = Words("en", (LANGUAGE_FILES,))
Namer = Callable[[str], str]
Values = dict[str, float]


@dataclass(frozen=True, slots=True)
class ReportTable:
    """A table with a heading per column; the first columns are words, the others numbers."""

    name: str
    title: str
    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    words: int  # how many of the columns are words
    note: str = ""
    empty: str = ""  # what stands in place of a table without rows


def performance(results: Results, name: Namer, words: Words = ENGLISH) -> ReportTable:
    """All maps together, in the layout of the paper's tables: a row per partner."""
    rows = [
        (name(partner), str(len(results.values("tcr", partner))), *_cells(results, partner, None))
        for partner in results.partners
    ]
    say = words.say
    measures = "; ".join(f"{metric.heading}: {words.known(f'measure.{metric.key}', metric.title)}" for metric in STORED)
    note = say("study.performance.note", legend=say("study.legend", measures=measures))
    heads = (say("study.partner"), say("study.rounds"), *HEADS.values())
    return ReportTable("performance", say("study.performance"), heads, tuple(rows), 1, note, say("study.empty"))


def performance_by_map(results: Results, name: Namer, words: Words = ENGLISH) -> ReportTable:
    rows = []
    for map_name in results.maps:
        for partner in results.partners:
            number = len(results.values("tcr", partner, map_name))
            rows.append((map_name, name(partner), str(number), *_cells(results, partner, map_name)))
    say = words.say
    heads = (say("study.map"), say("study.partner"), say("study.rounds"), *HEADS.values())
    title, empty = say("study.performance_by_map"), say("study.empty")
    return ReportTable("performance_by_map", title, heads, tuple(rows), 2, empty=empty)


def metric_comparisons(results: Results, name: Namer, words: Words = ENGLISH) -> ReportTable:
    """Every pair of partners in every metric, over means per participant."""
    found = _pairs(results, [(HEADS[metric], partial(results.per_unit, metric)) for metric in HEADS])
    return _comparison_table("metric_comparisons", found, name, words)


def rating_comparisons(results: Results, name: Namer, words: Words = ENGLISH) -> ReportTable:
    """Every pair of partners in every item, over participants."""
    measures: list[tuple[str, Callable[[str], Values]]] = [
        (label, partial(results.ratings, form, item.id)) for form, item, label in results.scales()
    ]
    return _comparison_table("rating_comparisons", _pairs(results, measures), name, words)


def ratings(results: Results, name: Namer, words: Words = ENGLISH) -> ReportTable:
    """Mean rating per item, a column per partner; questions at the end, about no partner, have one of their own."""
    at_the_end = any(results.ratings(form, item.id, AT_END) for form, item, _ in results.scales())
    about = (*results.partners, *([AT_END] if at_the_end else []))
    rows = []
    for form, item, label in results.scales():
        cells = [estimate_text(estimate(list(results.ratings(form, item.id, partner).values()))) for partner in about]
        if any(cell != "–" for cell in cells):
            rows.append((label, *cells))
    say = words.say
    heads = (say("study.ratings.item"), *(say("study.ratings.at_end") if one == AT_END else name(one) for one in about))
    note, empty = say("study.ratings.note"), say("study.ratings.empty")
    return ReportTable("ratings", say("study.ratings"), heads, tuple(rows), 1, note, empty)


def order_effects(results: Results, words: Words = ENGLISH) -> ReportTable:
    """Whether people got better over time, whichever partner they had."""
    rows = []
    for metric in HEADS:
        series: dict[int, list[float]] = defaultdict(list)
        for row in sorted(results.rounds, key=lambda row: row["position"]):
            if row[metric] is not None:
                series[row["unit"]].append(row[metric])
        found = trend(list(series.values()))
        if found is not None:
            rows.append((HEADS[metric], str(len(series)), f"{found[0]:+.2f}", _p(found[1])))
    say = words.say
    heads = (say("study.order.metric"), say("study.order.units"), say("study.order.rho"), "p")
    note, empty = say("study.order.note"), say("study.order.empty")
    return ReportTable("order_effects", say("study.order"), heads, tuple(rows), 1, note, empty)


def flow(results: Results, words: Words = ENGLISH) -> ReportTable:
    say = words.say
    rows = tuple((say(f"study.flow.{stage}"), str(number)) for stage, number in results.flow)
    heads = (say("study.flow.stage"), say("study.flow.number"))
    return ReportTable("flow", say("study.flow"), heads, rows, 1)


def flags(results: Results, words: Words = ENGLISH) -> ReportTable:
    say = words.say
    rows = tuple((one.pid or "–", one.step, words.phrase(one.reason)) for one in results.flags)
    heads = (say("study.participant"), say("study.flags.step"), say("study.flags.reason"))
    note, empty = say("study.flags.note"), say("study.flags.empty")
    return ReportTable("flags", say("study.flags"), heads, rows, 3, note, empty)


def pings(results: Results, name: Namer, words: Words = ENGLISH) -> ReportTable:
    """Who asked for help beside which partner, and whether the other came."""
    groups: dict[tuple[str, bool], list[PingRound]] = defaultdict(list)
    for one in results.pings:
        groups[one.partner, bool(one.player)].append(one)
    say = words.say
    asked = {True: say("study.pings.asked_by.participant"), False: say("study.pings.asked_by.partner")}
    rows = [
        (name(partner), asked[person], *_ping_cells(rounds, words))
        for (partner, person), rounds in sorted(groups.items(), key=lambda group: (name(group[0][0]), not group[0][1]))
        if person or any(one.pings for one in rounds)
    ]
    heads = (say("study.partner"), say("study.pings.asked_by"), *_ping_heads(words))
    return ReportTable("pings", say("study.pings"), heads, tuple(rows), 2, _ping_note(words))


def pings_by_participant(results: Results, words: Words = ENGLISH) -> ReportTable:
    groups: dict[str, list[PingRound]] = defaultdict(list)
    for one in results.pings:
        groups[one.player].append(one)
    rows = tuple((player, *_ping_cells(rounds, words)) for player, rounds in sorted(groups.items()) if player)
    title, heads = words.say("study.pings.by_participant"), (words.say("study.participant"), *_ping_heads(words))
    return ReportTable("pings_by_participant", title, heads, rows, 1, _ping_note(words))


def _ping_heads(words: Words) -> tuple[str, ...]:
    columns = ("pings", "per_round", "at_item", "followed", "seconds")
    return (words.say("study.rounds"), *(words.say(f"study.pings.{column}") for column in columns))


def _ping_note(words: Words) -> str:
    near, seconds = words.decimal(f"{NEAR:g}"), words.decimal(f"{FOLLOWED_WITHIN_S:g}")
    return words.say("study.pings.note", near=near, seconds=seconds)


def _ping_cells(rounds: Sequence[PingRound], words: Words) -> tuple[str, ...]:
    """What `_ping_heads` name."""
    said = [ping for one in rounds for ping in one.pings]
    away = [ping for ping in said if not ping.was_near]
    came = [ping.came_s for ping in away if ping.came_s is not None]
    return (
        str(len(rounds)),
        str(len(said)),
        estimate_text(estimate([float(len(one.pings)) for one in rounds])),
        str(sum(ping.ping.item != OWN_PLACE for ping in said)),
        words.say("study.pings.followed.of", came=len(came), away=len(away)),
        estimate_text(estimate(came)),
    )


def _cells(results: Results, partner: str, map_name: str | None) -> tuple[str, ...]:
    return tuple(estimate_text(estimate(results.values(metric, partner, map_name))) for metric in HEADS)


def _p(p: float | None) -> str:
    return "–" if p is None else "< 0.001" if p < 0.001 else f"{p:.3f}"


def _pairs(results: Results, measures: Sequence[tuple[str, Callable[[str], Values]]]) -> list[PartnerComparison]:
    found = [
        compare(label, one, other, of(one), of(other))
        for label, of in measures
        for one, other in combinations(results.partners, 2)
    ]
    return corrected([one for one in found if one is not None])


def _comparison_table(key: str, found: Sequence[PartnerComparison], name: Namer, words: Words) -> ReportTable:
    rows = [
        (
            one.measure,
            f"{name(one.one)} – {name(one.other)}",
            f"{one.difference:+.3f}",
            "–" if one.t is None else f"{one.t:.2f}",
            _p(one.t_p),
            str(one.pairs),
            _p(one.w_p),
            _p(one.holm_p),
            "–" if one.g is None or one.g_interval is None
            else f"{one.g:+.2f} [{one.g_interval[0]:+.2f}, {one.g_interval[1]:+.2f}]",
        )
        for one in found
    ]  # fmt: skip
    say = words.say
    measure, partners, difference, pairs = (
        say(f"study.comparison.{head}") for head in ("measure", "partners", "difference", "pairs")
    )
    heads = (measure, partners, difference, "t", "p (t)", pairs, "p (Wilcoxon)", "p (Holm)", "g [95 %]")
    note, empty = say("study.comparison.note"), say("study.comparison.empty")
    return ReportTable(key, say(f"study.{key}"), heads, tuple(rows), 2, note, empty)
