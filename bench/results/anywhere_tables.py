"""The tables of `bench.anywhere`: agents by groups of maps.

Episodes on the same map resemble each other, so errors are those over maps: first the mean of each map, then mean and
standard error of these. A map that was played more often counts no more than another.
"""

from collections.abc import Callable, Mapping, Sequence

from bench.results.episode_log import Outcome
from movingout.world.estimates import Estimate, difference_text, estimate, estimate_text

CONTROL = "idle"
NOTE = (
    "± is the standard error over maps, each with the mean of its episodes. In brackets the difference to the idle "
    "partner over the same episodes."
)
Played = Mapping[str, Mapping[str, Sequence[Outcome]]]
"""Outcomes by agent and group of maps; those of all agents are of the same episodes in the same order."""
_METRICS = {"tcr": "TCR", "nfd": "NFD"}


def tables(played: Played) -> str:
    """All tables of one group of partners, in Markdown."""
    parts = [table(played, metric) for metric in _METRICS] + [NOTE]
    agents = list(played)
    if len(agents) > 1:
        parts.append(differences(played, agents[0], agents[1]))
    if CONTROL in played and len(agents) > 1:
        parts.append(idle_was_better(played))
    return "\n\n".join([*parts, interdependence(played)])


def table(played: Played, metric: str = "tcr") -> str:
    """Agents by groups of maps, `mean ± SE (difference to idle ± SE)`."""

    def cell(agent: str, column: str) -> str:
        text = estimate_text(over_maps(played[agent][column], metric))
        if agent == CONTROL or CONTROL not in played:
            return text
        return f"{text} ({difference_text(gain(played, agent, CONTROL, column, metric))})"

    return _rows(played, _METRICS[metric], list(played), cell)


def differences(played: Played, one: str, other: str) -> str:
    """Of two agents over the same episodes."""
    rows = {f"{name}, {one} minus {other}": metric for metric, name in _METRICS.items()}
    return _rows(
        played,
        "difference",
        list(rows),
        lambda row, column: difference_text(gain(played, one, other, column, rows[row])),
    )


def idle_was_better(played: Played) -> str:
    """The share of episodes in which the partner reached more beside the idle one."""
    agents = [agent for agent in played if agent != CONTROL]
    return _rows(played, "idle was better", agents, lambda agent, column: f"{idle_share(played, agent, column):.0%}")


def interdependence(played: Played) -> str:
    """Of what was delivered, the share that the one who did not deliver it had carried a part of the way."""

    def cell(agent: str, column: str) -> str:
        return estimate_text(over_maps(played[agent][column], "interdependence"))

    return _rows(played, "interdependence", list(played), cell)


def over_maps(outcomes: Sequence[Outcome], metric: str) -> Estimate | None:
    """Mean and standard error of a metric over maps; without the episodes that do not have it."""
    values: list[tuple[str, float | None]] = [(one.run.map, getattr(one, metric)) for one in outcomes]
    return _clustered([(name, value) for name, value in values if value is not None])


def gain(played: Played, one: str, other: str, column: str, metric: str) -> Estimate | None:
    """The difference between two agents, likewise."""
    pairs = zip(played[one][column], played[other][column], strict=True)
    return _clustered([(mine.run.map, getattr(mine, metric) - getattr(theirs, metric)) for mine, theirs in pairs])


def idle_share(played: Played, agent: str, column: str) -> float:
    """The share of episodes in which the idle partner had a higher TCR."""
    pairs = list(zip(played[agent][column], played[CONTROL][column], strict=True))
    return sum(idle.tcr > mine.tcr for mine, idle in pairs) / len(pairs)


def _clustered(values: Sequence[tuple[str, float]]) -> Estimate | None:
    by_map: dict[str, list[float]] = {}
    for name, value in values:
        by_map.setdefault(name, []).append(value)
    return estimate([sum(those) / len(those) for those in by_map.values()])


def _rows(played: Played, head: str, names: Sequence[str], cell: Callable[[str, str], str]) -> str:
    cells = next(iter(played.values()))
    lines = [f"| {head} | {' | '.join(cells)} | n per cell |", "|---" * (len(cells) + 2) + "|"]
    count = min(map(len, cells.values()))
    return "\n".join(
        lines + [f"| {name} | {' | '.join(cell(name, column) for column in cells)} | {count} |" for name in names]
    )
