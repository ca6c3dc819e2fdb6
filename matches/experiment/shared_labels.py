"""Labels of a grid that stand for several agents with the same partners: tables give the mean of them all."""

from collections import defaultdict
from collections.abc import Iterator

from movingout.matches.experiment.grid import Condition, Grid


def shared_label_cautions(grid: Grid) -> Iterator[str]:
    """A sentence for each such label.

    Agents of one label with different partners, such as models of disjoint groups, are pooled on purpose.
    """
    for condition in grid.all_conditions:
        for label, agents in _labelled(condition).items():
            partners = list(agents.values())
            if len({one for met in partners for one in met}) < sum(map(len, partners)):
                yield (
                    f"{label} stands for {len(agents)} agents with the same partners in {condition.name}: "
                    f"{', '.join(agents)}; tables give their mean, so give each a label of its own to tell them apart"
                )


def _labelled(condition: Condition) -> dict[str, dict[str, set[str]]]:
    """The partners of each agent, by label."""
    found: defaultdict[str, defaultdict[str, set[str]]] = defaultdict(lambda: defaultdict(set))
    for one in condition.contestants:
        found[one.name][one.agent] |= set(condition.partners_of(one))
    return {label: dict(agents) for label, agents in found.items()}
