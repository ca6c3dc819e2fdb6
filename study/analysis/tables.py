"""The tables of a report; each is part of the page and a CSV file."""

from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import combinations

from movingout.recordings.pings import FOLLOWED_WITHIN_S, NEAR
from movingout.study.analysis.comparisons import PartnerComparison, compare, corrected, trend
from movingout.study.analysis.pings import PingRound
from movingout.study.analysis.results import STORED, Results
from movingout.world.estimates import estimate, estimate_text
from movingout.world.ping import OWN_PLACE

HEADS = {metric.key: f"{metric.heading} {'↑' if metric.higher_is_better else '↓'}" for metric in STORED}
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


def performance(results: Results, name: Namer) -> ReportTable:
    """All maps together, in the layout of the paper's tables: a row per partner."""
    rows = [
        (name(partner), str(len(results.values("tcr", partner))), *_cells(results, partner, None))
        for partner in results.partners
    ]
    note = "Mean ± standard error over rounds. A round without a value of a metric is left out of its mean."
    return ReportTable(
        "performance", "Results by partner", ("Partner", "rounds", *HEADS.values()), tuple(rows), 1, note
    )


def performance_by_map(results: Results, name: Namer) -> ReportTable:
    rows = []
    for map_name in results.maps:
        for partner in results.partners:
            number = len(results.values("tcr", partner, map_name))
            rows.append((map_name, name(partner), str(number), *_cells(results, partner, map_name)))
    heads = ("Map", "Partner", "rounds", *HEADS.values())
    return ReportTable("performance_by_map", "Results by map", heads, tuple(rows), 2)


def metric_comparisons(results: Results, name: Namer) -> ReportTable:
    """Every pair of partners in every metric, over means per participant."""
    found = _pairs(results, [(HEADS[metric], partial(results.per_unit, metric)) for metric in HEADS])
    return _comparison_table("metric_comparisons", "Partners compared: performance", found, name)


def rating_comparisons(results: Results, name: Namer) -> ReportTable:
    """Every pair of partners in every item, over participants."""
    measures: list[tuple[str, Callable[[str], Values]]] = [
        (item.label, partial(results.ratings, form, item.id)) for form, item in results.scales()
    ]
    return _comparison_table("rating_comparisons", "Partners compared: ratings", _pairs(results, measures), name)


def ratings(results: Results, name: Namer) -> ReportTable:
    """Mean rating per item, a column per partner; questions at the end, about no partner, are under "all"."""
    about = (*results.partners, *([] if "" in results.partners else [""]))
    rows = []
    for form, item in results.scales():
        cells = [estimate_text(estimate(list(results.ratings(form, item.id, partner).values()))) for partner in about]
        if any(cell != "–" for cell in cells):
            rows.append((item.label, *cells))
    heads = ("Item", *(name(partner) if partner in results.partners else "all" for partner in about))
    return ReportTable("ratings", "Ratings", heads, tuple(rows), 1, "Mean ± standard error over participants.")


def order_effects(results: Results) -> ReportTable:
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
    heads = ("Metric", "participants or pairs", "mean rho", "p")
    note = "Spearman's rank correlation of the metric with the position of the round, per participant; p by Wilcoxon."
    return ReportTable("order_effects", "Order effects", heads, tuple(rows), 1, note)


def flow(results: Results) -> ReportTable:
    rows = tuple((words, str(number)) for words, number in results.flow)
    return ReportTable("flow", "Participants", ("Flow", "number"), rows, 1)


def flags(results: Results) -> ReportTable:
    rows = tuple((one.pid or "–", one.step, one.reason) for one in results.flags)
    note = "Flags exclude nothing. Invalid and unfinished rounds are not in the results."
    return ReportTable("flags", "Quality flags", ("Participant", "Step", "Reason"), rows, 3, note)


def pings(results: Results, name: Namer) -> ReportTable:
    """Who asked for help beside which partner, and whether the other came."""
    groups: dict[tuple[str, bool], list[PingRound]] = defaultdict(list)
    for one in results.pings:
        groups[one.partner, bool(one.player)].append(one)
    rows = [
        (name(partner), "participant" if person else "partner", *_ping_cells(rounds))
        for (partner, person), rounds in sorted(groups.items(), key=lambda group: (group[0][0], not group[0][1]))
        if person or any(one.pings for one in rounds)
    ]
    heads = ("Partner", "Asked by", *PING_HEADS)
    return ReportTable("pings", "Pings by partner", heads, tuple(rows), 2, PING_NOTE)


def pings_by_participant(results: Results) -> ReportTable:
    groups: dict[str, list[PingRound]] = defaultdict(list)
    for one in results.pings:
        groups[one.player].append(one)
    rows = tuple((player, *_ping_cells(rounds)) for player, rounds in sorted(groups.items()) if player)
    return ReportTable("pings_by_participant", "Pings by participant", ("Participant", *PING_HEADS), rows, 1, PING_NOTE)


PING_HEADS = ("rounds", "pings", "per round", "at an item", "followed", "seconds until then")
PING_NOTE = (
    f"Followed: of the pings that were said while the other was elsewhere, those after which the other was within "
    f"{NEAR:g} arena units of the place or the item, or held it, within {FOLLOWED_WITHIN_S:g} s. "
    "Mean ± standard error. Pings that came too fast one after another are refused and not counted here."
)


def _ping_cells(rounds: Sequence[PingRound]) -> tuple[str, ...]:
    """What PING_HEADS name."""
    said = [ping for one in rounds for ping in one.pings]
    away = [ping for ping in said if not ping.was_near]
    came = [ping.came_s for ping in away if ping.came_s is not None]
    return (
        str(len(rounds)),
        str(len(said)),
        estimate_text(estimate([float(len(one.pings)) for one in rounds])),
        str(sum(ping.ping.item != OWN_PLACE for ping in said)),
        f"{len(came)} of {len(away)}",
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


def _comparison_table(key: str, title: str, found: Sequence[PartnerComparison], name: Namer) -> ReportTable:
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
    heads = ("Measure", "Partners", "difference", "t", "p (t)", "pairs", "p (Wilcoxon)", "p (Holm)", "g [95 %]")
    note = (
        "Over means per participant. t: independent t-test, as in the paper. Wilcoxon: signed-rank test of those who "
        "met both, the better choice here; Holm: corrected over this table. g: Hedges' g with its 95 % interval."
    )
    return ReportTable(key, title, heads, tuple(rows), 2, note)
