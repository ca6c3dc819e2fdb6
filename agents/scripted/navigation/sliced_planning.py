"""Planning in slices, so that no decision takes long: a computation is a generator that yields after each slice.

Slices are counted rather than timed, so that equal states give equal actions on any machine.
"""

from collections.abc import Callable, Generator
from typing import Generic, TypeVar

from movingout.agents.scripted.navigation.cost_search import CostToGo

T = TypeVar("T")
Computation = Generator[None, None, T]

SEARCH_MARGIN = 60  # quarter ticks beyond the wanted cost, for robots that are pushed off the path


class SlicedComputation(Generic[T]):
    """A computation in progress."""

    def __init__(self, steps: Computation[T]) -> None:
        self._steps = steps
        self.done = False
        self._result: list[T] = []

    def advance(self, slices: int) -> int:
        """Run up to this many slices; returns how many are left."""
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
        """The result, once `done`."""
        return self._result[0]


def solve(field: CostToGo, known: Callable[[], float]) -> Computation[None]:
    """Search until the wanted cost, as `known` so far, cannot improve, and a little farther."""
    while not field.done and field.level < known() + SEARCH_MARGIN:
        field.search()
        yield
