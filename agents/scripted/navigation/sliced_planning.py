"""Planning in slices, so that no single decision takes long: a thought is a generator that yields between slices.

Slices are counted, never timed: the same states give the same actions on any machine.
"""

from collections.abc import Callable, Generator
from typing import Generic, TypeVar

from movingout.agents.scripted.navigation.cost_search import CostToGo

T = TypeVar("T")
Computation = Generator[None, None, T]

SEARCH_MARGIN = 60  # quarter ticks of cost-to-go beyond the start, for whoever is pushed off the way


class SlicedComputation(Generic[T]):
    """A thought on its way to a result."""

    def __init__(self, steps: Computation[T]) -> None:
        self._steps = steps
        self.done = False
        self._result: list[T] = []

    def advance(self, slices: int) -> int:
        """Think for up to this many slices; return how many are left."""
        while slices > 0 and not self.done:
            slices -= 1
            try:
                next(self._steps)
            except StopIteration as end:
                self._result.append(end.value)
                self.done = True
        return slices

    @property
    def result(self) -> T:
        """What came out; only when `done`."""
        return self._result[0]


def solve(field: CostToGo, known: Callable[[], float]) -> Computation[None]:
    """Search a field until what is `known` of the wanted cost cannot get better, and a little farther."""
    while not field.done and field.level < known() + SEARCH_MARGIN:
        field.search()
        yield
