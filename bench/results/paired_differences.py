"""Paired differences between agents over the episodes that both played."""

from collections.abc import Mapping, Sequence

from bench._roster import Comparison
from bench.results.episode_log import Outcome
from movingout.agents.curriculum.roster import BASS
from movingout.world.estimates import difference_text, estimate, estimate_text

TARGET_TCR = 0.65
LEGEND = (
    "Differences with the same partner, map, seat and seed; **bold** where the means differ by more than the sum of "
    "their standard errors."
)


def against_aim(outcomes: Sequence[Outcome]) -> str:
    """A sentence on the aim and whether it was reached."""
    found = estimate([one.tcr for one in outcomes if one.run.agent == BASS])
    if found is None:
        return f"`{BASS}` has not played; the aim is a TCR of {TARGET_TCR}."
    reached = "reached" if found.mean >= TARGET_TCR else f"missed by {TARGET_TCR - found.mean:.3f}"
    return f"`{BASS}` TCR {estimate_text(found)}; target {TARGET_TCR}: {reached}."


def leads(field: Comparison, played: Mapping[str, Sequence[Outcome]]) -> str:
    """A Markdown table of the compared pairs that have played, with columns per population."""
    groups = [group for group in field.partners if played[group]]
    heads = [f"{field.partners[group]}: " if len(groups) > 1 else "" for group in groups]
    lines = ["| | " + " | ".join(f"{head}TCR | NFD | n" for head in heads) + " |", "|---" * (1 + 3 * len(groups)) + "|"]
    for one, other in field.compared:
        cells = [cell for group in groups for cell in _cells(played[group], one, other)]
        if any(cells):
            lines.append(f"| `{one}` minus `{other}` | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _cells(outcomes: Sequence[Outcome], one: str, other: str) -> list[str]:
    """TCR, NFD and n; empty if the two share no episodes."""
    count = len(gains(outcomes, one, other, "tcr"))
    return [*(lead(outcomes, one, other, metric) for metric in ("tcr", "nfd")), str(count)] if count else [""] * 3


def lead(outcomes: Sequence[Outcome], one: str, other: str, metric: str) -> str:
    """The mean difference with its standard error, bold if the means differ by more than their summed errors."""
    gain = estimate(gains(outcomes, one, other, metric))
    mine, theirs = (estimate(values) for values in shared(outcomes, one, other, metric))
    if gain is None or mine is None or theirs is None:
        return "–"
    cell = difference_text(gain)
    errors = (mine.stderr or 0.0) + (theirs.stderr or 0.0)
    return f"**{cell}**" if mine.stderr and abs(mine.mean - theirs.mean) > errors else cell


def gains(outcomes: Sequence[Outcome], one: str, other: str, metric: str) -> list[float]:
    """Differences of a metric between two agents over the episodes that both played."""
    mine, theirs = shared(outcomes, one, other, metric)
    return [a - b for a, b in zip(mine, theirs, strict=True)]


def shared(outcomes: Sequence[Outcome], one: str, other: str, metric: str) -> tuple[list[float], list[float]]:
    """The metric of two agents in the episodes that both played, in the same order."""

    def of(agent: str) -> dict[tuple[object, ...], float]:
        return {
            (o.run.partner, o.run.map, o.run.seat, o.run.seed): getattr(o, metric)
            for o in outcomes
            if o.run.agent == agent
        }

    mine, theirs = of(one), of(other)
    both = [key for key in mine if key in theirs]
    return [mine[key] for key in both], [theirs[key] for key in both]
