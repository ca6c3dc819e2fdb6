"""The paper's figures by the names that grids give them: `paper: "tab:task_1_results: Seen"` is a label and a group."""

from collections.abc import Mapping

from movingout.matches.paper.published import Figure, published_tables

PAPER_METRICS = ("tcr", "nfd", "waiting_share", "ac")
_METHODS = "tab:full_results_in_t1, _t2"
_EARLIER = {
    "tab:full_results_in_t2: Challenge 2": "fig:results_t2: Challenge 2",
    **{f"{_METHODS}: {name}": f"tab:full_results_in_t{{challenge}}: {name}" for name in ("MLP", "GRU", "DP")},
}
"""Names that the shipped grids and older results folders use, and the label and group that they mean."""
_COMPARABLE = ("tab:", "table:", "fig:results")


def paper_figures(table: str, challenge: int, row: str) -> Mapping[str, Figure]:
    """The paper's figures of one row, by metric; empty when it has none."""
    label, _, group = _EARLIER.get(table, table).format(challenge=challenge).rpartition(": ")
    if label not in published_tables():
        return {}
    return {
        column.measure: figure
        for found in published_tables()[label].rows
        if (found.group, found.name) == (group, row)
        for column, figure in found.figures.items()
        if column.challenge == challenge and column.measure in PAPER_METRICS
    }


def paper_tables() -> set[str]:
    """What `paper:` in a grid may name."""
    groups = {
        f"{label}: {row.group}"
        for label, table in published_tables().items()
        for row in table.rows
        if row.group and label.startswith(_COMPARABLE)
    }
    return groups | set(_EARLIER)
