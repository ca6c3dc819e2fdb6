"""The tables of a report; each is part of the page and a CSV file."""

from collections import Counter, defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import combinations
from pathlib import Path
from typing import NamedTuple

from movingout.recordings.pings import FOLLOWED_WITHIN_S, NEAR
from movingout.recordings.report.words import Words
from movingout.study.analysis.cells import Paired
from movingout.study.analysis.comparisons import PartnerComparison, compare, corrected, trend
from movingout.study.analysis.pings import PingRound
from movingout.study.analysis.questions import AskedItem, counted_items, rated_items
from movingout.study.analysis.results import STORED, Results
from movingout.study.questionnaire import NO_ANSWER
from movingout.world.estimates import estimate, estimate_text
from movingout.world.ping import OWN_PLACE

HEADS = {metric.key: f"{metric.heading} {'↑' if metric.higher_is_better else '↓'}" for metric in STORED}
LANGUAGE_FILES = Path(__file__).with_name("languages")
ENGLISH = Words("en", (LANGUAGE_FILES,))
Namer = Callable[[str], str]
Values = dict[str, float]
Measure = tuple[str, Callable[[str, str], Paired]]


class Comparisons(NamedTuple):
    """What a table of comparisons shows."""

    rows: list[tuple[tuple[str, ...], PartnerComparison]]  # with the column of its blocks
    left_out: frozenset[tuple[str, str]]  # of at least one: participant, and round or answer


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
    blocks = results.by_condition()
    rows = [
        (
            *block_cells(blocks, label),
            name(partner),
            str(len(part.values("tcr", partner))),
            *_cells(part, partner, None),
        )
        for label, part in blocks
        for partner in part.partners
    ]
    say = words.say
    measures = "; ".join(f"{metric.heading}: {words.known(f'measure.{metric.key}', metric.title)}" for metric in STORED)
    note = say("study.performance.note", legend=say("study.legend", measures=measures))
    head = block_cells(blocks, say("study.block"))
    heads = (*head, say("study.partner"), say("study.rounds"), *HEADS.values())
    title, empty = say("study.performance"), say("study.empty")
    return ReportTable("performance", title, heads, tuple(rows), len(head) + 1, note, empty)


def performance_by_map(results: Results, name: Namer, words: Words = ENGLISH) -> ReportTable:
    blocks, rows = results.by_condition(), []
    for label, part in blocks:
        for map_name in part.maps:
            for partner in part.partners:
                number = str(len(part.values("tcr", partner, map_name)))
                where = (*block_cells(blocks, label), map_name, name(partner), number)
                rows.append((*where, *_cells(part, partner, map_name)))
    say = words.say
    head = block_cells(blocks, say("study.block"))
    heads = (*head, say("study.map"), say("study.partner"), say("study.rounds"), *HEADS.values())
    title, empty = say("study.performance_by_map"), say("study.empty")
    return ReportTable("performance_by_map", title, heads, tuple(rows), len(head) + 2, empty=empty)


def metric_comparisons(results: Results, name: Namer, words: Words = ENGLISH) -> ReportTable:
    """Every pair of partners in every metric, over means per participant."""
    found = _pairs(results, lambda part: [(HEADS[metric], partial(part.compare_rounds, metric)) for metric in HEADS])
    return _comparison_table("metric_comparisons", found, name, words)


def rating_comparisons(results: Results, name: Namer, words: Words = ENGLISH) -> ReportTable:
    """Every pair of partners in every item, over participants (or pairs)."""
    items = rated_items(results.study)
    found = _pairs(results, lambda part: [(rated.label, partial(_compare_ratings, part, rated)) for rated in items])
    return _comparison_table("rating_comparisons", found, name, words)


def ratings(results: Results, name: Namer, words: Words = ENGLISH) -> ReportTable:
    """Mean rating per item, a column per partner; questions at the end, about no partner, have one of their own."""
    items, blocks = rated_items(results.study), results.by_condition()
    at_the_end = [None] if any(_ratings(results, rated, None) for rated in items) else []
    about: tuple[str | None, ...] = (*results.rated_partners, *at_the_end)
    rows = []
    for label, part in results.by_condition_asked():
        for rated in items:
            cells = [estimate_text(estimate(list(_ratings(part, rated, one).values()))) for one in about]
            if any(cell != "–" for cell in cells):
                rows.append((*block_cells(blocks, label or "–"), rated.label, *cells))
    say = words.say
    head = (*block_cells(blocks, say("study.block")), say("study.ratings.item"))
    heads = (*head, *(say("study.ratings.at_end") if one is None else name(one) for one in about))
    note, empty = say("study.ratings.note"), say("study.ratings.empty")
    return ReportTable("ratings", say("study.ratings"), heads, tuple(rows), len(head), note, empty)


def choices(results: Results, name: Namer, words: Words = ENGLISH) -> ReportTable:
    """How often each answer was given, where a mean says nothing."""
    blocks, say, rows = results.by_condition(), words.say, []
    for asked in counted_items(results.study, words.language):
        for label, part in results.by_condition_asked():
            for partner in (*part.rated_partners, None):
                found = part.counts(asked.questionnaire, asked.item.id, partner, asked.occasions)
                where = (*block_cells(blocks, label or "–"), asked.label, _about(asked, partner, name, words))
                rows += [(*where, text, str(number)) for text, number in _answers(asked, found, words)]
    head = (
        *block_cells(blocks, say("study.block")),
        *(say(f"study.choices.{one}") for one in ("item", "about", "answer")),
    )
    heads, title, empty = (*head, say("study.choices.number")), say("study.choices"), say("study.ratings.empty")
    return ReportTable("choices", title, heads, tuple(rows), len(head), say("study.choices.note"), empty)


def _about(asked: AskedItem, partner: str | None, name: Namer, words: Words) -> str:
    if partner is not None:
        return name(partner)
    return words.say("study.choices.at_the_start" if "demographics" in asked.occasions else "study.ratings.at_end")


def _answers(asked: AskedItem, found: Counter[int], words: Words) -> list[tuple[str, int]]:
    """All options of a choice, the values given of a scale; nothing where nobody was asked."""
    if not found:
        return []
    options = list(enumerate(asked.item.options)) or [(value, str(value)) for value in sorted(found) if value >= 0]
    refused = [(words.say("study.choices.none"), found[NO_ANSWER])] if found[NO_ANSWER] else []
    return [*((text, found[value]) for value, text in options), *refused]


def order_effects(results: Results, words: Words = ENGLISH) -> ReportTable:
    """Whether people got better over time, whichever partner they had."""
    blocks, rows = results.by_condition(), []
    for label, part in blocks:
        for metric in HEADS:
            series: dict[int, list[float]] = defaultdict(list)
            for row in sorted(part.rounds, key=lambda row: row["position"]):
                if row[metric] is not None:
                    series[row["unit"]].append(row[metric])
            found = trend(list(series.values()))
            if found is not None:
                used = words.say("study.order.units.of", used=found.used, all=len(series))
                rows.append((*block_cells(blocks, label), HEADS[metric], used, f"{found.rho:+.2f}", _p(found.p)))
    say = words.say
    head = (*block_cells(blocks, say("study.block")), say("study.order.metric"))
    heads = (*head, say("study.order.units"), say("study.order.rho"), "p")
    note, empty = say("study.order.note"), say("study.order.empty")
    return ReportTable("order_effects", say("study.order"), heads, tuple(rows), len(head), note, empty)


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
    say, blocks, rows = words.say, results.by_condition(), []
    asked = {True: say("study.pings.asked_by.participant"), False: say("study.pings.asked_by.partner")}
    for label, part in blocks:
        groups: dict[tuple[str, bool], list[PingRound]] = defaultdict(list)
        for one in part.pings:
            groups[one.partner, bool(one.player)].append(one)
        rows += [
            (*block_cells(blocks, label), name(partner), asked[person], *_ping_cells(groups[partner, person], words))
            for partner, person in sorted(groups, key=lambda group: (name(group[0]), not group[1]))
            if person or any(one.pings for one in groups[partner, person])
        ]
    head = (*block_cells(blocks, say("study.block")), say("study.partner"), say("study.pings.asked_by"))
    heads = (*head, *_ping_heads(words))
    return ReportTable("pings", say("study.pings"), heads, tuple(rows), len(head), _ping_note(words))


def pings_by_participant(results: Results, words: Words = ENGLISH) -> ReportTable:
    say, blocks, rows = words.say, results.by_condition(), []
    for label, part in blocks:
        groups: dict[str, list[PingRound]] = defaultdict(list)
        for one in part.pings:
            groups[one.player].append(one)
        where = block_cells(blocks, label)
        rows += [(*where, player, *_ping_cells(groups[player], words)) for player in sorted(groups) if player]
    head = (*block_cells(blocks, say("study.block")), say("study.participant"))
    title, heads = say("study.pings.by_participant"), (*head, *_ping_heads(words))
    return ReportTable("pings_by_participant", title, heads, tuple(rows), len(head), _ping_note(words))


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


def block_cells(blocks: Sequence[tuple[str, Results]], label: str) -> tuple[str, ...]:
    """The column of blocks, where there are several that may not be pooled."""
    return (label,) if len(blocks) > 1 else ()


def _ratings(results: Results, rated: AskedItem, partner: str | None) -> Values:
    return results.ratings(rated.questionnaire, rated.item.id, partner, rated.occasions)


def _compare_ratings(results: Results, rated: AskedItem, one: str, other: str) -> Paired:
    return results.compare_ratings(rated.questionnaire, rated.item.id, one, other, rated.occasions)


def _pairs(results: Results, measures: Callable[[Results], Sequence[Measure]]) -> Comparisons:
    """Partners are compared within blocks that may be pooled; p is corrected over all of them."""
    blocks = results.by_condition()
    values = [
        (block_cells(blocks, block), label, one, other, of(one, other))
        for block, part in blocks
        for label, of in measures(part)
        for one, other in combinations(part.rated_partners, 2)
    ]
    found = [(block, compare(label, one, other, both.first, both.second)) for block, label, one, other, both in values]
    compared = [(block, one) for block, one in found if one is not None]
    rows = list(zip([block for block, _ in compared], corrected([one for _, one in compared]), strict=True))
    return Comparisons(rows, frozenset().union(*(both.left_out for *_, both in values)))


def _comparison_table(key: str, found: Comparisons, name: Namer, words: Words) -> ReportTable:
    rows = [
        (
            *block,
            one.measure,
            f"{name(one.one)} – {name(one.other)}",
            f"{one.difference:+.3f}",
            f"{one.n[0]} / {one.n[1]}",
            "–" if one.t is None else f"{one.t:.2f}",
            _p(one.t_p),
            str(one.pairs),
            _p(one.w_p),
            _p(one.holm_p),
            "–" if one.g is None or one.g_interval is None
            else f"{one.g:+.2f} [{one.g_interval[0]:+.2f}, {one.g_interval[1]:+.2f}]",
        )
        for block, one in found.rows
    ]  # fmt: skip
    say = words.say
    measure, partners, difference, pairs = (
        say(f"study.comparison.{head}") for head in ("measure", "partners", "difference", "pairs")
    )
    head = tuple(say("study.block") for _ in found.rows[0][0]) if found.rows else ()
    heads = (*head, measure, partners, difference, "n", "t", "p (t)", pairs, "p (Wilcoxon)", "p (Holm)", "g [95 %]")
    note, empty = _comparison_note(found, words), say("study.comparison.empty")
    return ReportTable(key, say(f"study.{key}"), heads, tuple(rows), len(head) + 2, note, empty)


def _comparison_note(found: Comparisons, words: Words) -> str:
    note, left_out = words.say("study.comparison.note"), found.left_out
    if not left_out:
        return note
    who = len({who for who, _ in left_out})
    return f"{note} {words.say('study.comparison.left_out', values=len(left_out), who=who)}"
