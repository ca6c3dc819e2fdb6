"""Being nowhere in particular: waiting somewhere, and standing aside."""

from collections.abc import Callable

from movingout.agents.scripted.carrying.solo_carry import Body
from movingout.agents.scripted.navigation.motion_choice import REST, Command, Danger, best_move
from movingout.agents.scripted.navigation.sliced_planning import Thinking, Thought, solve
from movingout.agents.scripted.navigation.walking_distance import way_to
from movingout.agents.scripted.situation import Situation
from movingout.agents.scripted.traffic import aside
from movingout.maps.flood_fill import UNREACHED
from movingout.world.state import Floats


class WalkTo:
    """Going somewhere to wait there."""

    item = -1
    hopeless = False

    def __init__(self, now: Situation, place: tuple[float, float], until: int) -> None:
        self.until = until
        self._way = way_to(now.ground(), [place])

    def step(self, now: Situation, danger: Danger, slices: int) -> Command | None:
        """Over after its time."""
        if now.tick >= self.until or now.mine >= 0:
            return None
        if self._way.cost(float(now.pose[0]), float(now.pose[1])) <= 4.0:
            return REST
        return best_move(now.pose, lambda moves: self._way.costs(moves) + danger(moves))[0]


class Aside:
    """Leaving the way to the partner, for as long as it takes."""

    item = -1
    hopeless = False

    def __init__(
        self,
        now: Situation,
        way: Floats,
        until: int,
        needed: Callable[[Situation], bool] | None = None,
        hands_over: bool = False,
    ) -> None:
        """It lasts until a tick, or as long as it is `needed` where that can be said.

        Who `hands_over` puts down there what it holds, for the partner to take home.
        """
        self.until = until
        self.handed_over = -1
        self._hands_over = hands_over
        self._needed = needed
        self._held = now.mine
        self._body: Thinking[Body] = Thinking(self._think(now, way))

    def step(self, now: Situation, danger: Danger, slices: int) -> Command | None:
        """Over after its time, or when there is nowhere to go."""
        self._body.advance(2 * slices)
        if now.mine != self._held or (now.tick >= self.until if self._needed is None else not self._needed(now)):
            return None
        if not self._body.done:
            return REST
        body = self._body.result
        here = body.cost(now.pose)
        if here >= UNREACHED:
            return None
        if here < 1.5 and self._hands_over and now.mine >= 0:
            self.handed_over = now.mine
            return Command(0.0, 0.0, grasp=True)
        if here < 1.5:
            return REST
        return body.move(now.pose, danger)

    def _think(self, now: Situation, way: Floats) -> Thought[Body]:
        body = aside(now, way)
        yield
        yield from solve(body.field, lambda: body.cost(now.pose))
        return body
