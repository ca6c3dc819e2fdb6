"""What a scripted player can be busy with: fetching, carrying, lifting together. Each errand drives one robot.

An errand's `step` gives the next command, or None when it is over (done or hopeless).
"""

import math
from typing import Protocol

import numpy as np

from agents.scripted.driving import REST, Command, Danger, best_move, drive, turn_to
from agents.scripted.geometry import heading_of, wrap
from agents.scripted.grasping import GAP, in_frame, stand, within_reach
from agents.scripted.hauling import EASY, TIGHT, Haul
from agents.scripted.lattice import UNREACHED
from agents.scripted.pairing import PairHaul
from agents.scripted.situation import Situation
from agents.scripted.terrain import Terrain, sample
from agents.scripted.thinking import Thinking, Thought, solve
from agents.scripted.walking import Way, cost_at, walk_field
from maps.spec import ROBOT_RADIUS
from world.state import Floats

HEADINGS = tuple(k * math.pi / 8 for k in range(16))
NEAR = 0.07  # units from its stand at which a robot turns to the item


class Errand(Protocol):
    """One thing to do."""

    item: int

    def step(self, now: Situation, danger: Danger, slices: int) -> Command | None: ...


def walk_costs(now: Situation, ground: Terrain, position: Floats, stands: list[Floats]) -> list[float]:
    """Quarter ticks on foot from a position to each stand; UNREACHED for those in the way of something."""
    field = walk_field(ground, [(float(position[0]), float(position[1]))])
    costs = []
    for pose in stands:
        room = float(sample(ground.clearance, pose[0:1], pose[1:2])[0])
        costs.append(cost_at(field, float(pose[0]), float(pose[1])) if room >= ROBOT_RADIUS - 0.004 else UNREACHED)
    return costs


class Approach:
    """Walking to a stand beside an item and closing the hand."""

    def __init__(self, ground: Terrain, item: int, target: Floats) -> None:
        self.item = item
        self.target = target
        self.ground = ground
        self.way = Way(ground, [(float(target[0]), float(target[1]))])

    def step(self, now: Situation, danger: Danger) -> Command:
        """The next command; with a grasp as soon as the hand reaches the item."""
        pose, goal = now.pose, now.item_pose(self.item)
        to_item = heading_of(float(goal[0] - pose[0]), float(goal[1] - pose[1]))
        off = wrap(to_item - float(pose[2]))
        if within_reach(now.item(self.item), goal, pose) and abs(off) < 0.6:
            return Command(0.3, float(pose[2]), grasp=True)
        gap = math.hypot(float(pose[0] - self.target[0]), float(pose[1] - self.target[1]))
        if gap < NEAR or math.hypot(goal[0] - pose[0], goal[1] - pose[1]) < self._arm(now) + 0.03:
            return drive(to_item) if abs(off) < 0.3 else turn_to(to_item)
        command, _ = best_move(pose, lambda moves: self.way.costs(moves) + danger(moves))
        return command

    def _arm(self, now: Situation) -> float:
        goal = now.item_pose(self.item)
        return math.hypot(float(goal[0] - self.target[0]), float(goal[1] - self.target[1]))


class Fetch:
    """Going to a small item; knows on the way how it will be carried, and so from which side to take it."""

    def __init__(self, now: Situation, item: int) -> None:
        self.item = item
        self.haul: Haul | None = None
        self.hopeless = False
        self._ground = now.ground()
        self._item_pose = now.item_pose(item)
        goal = now.item_pose(item)
        self._approach = Approach(self._ground, item, np.array([goal[0], goal[1], 0.0]))
        self._thinking: Thinking[tuple[Haul, Floats] | None] = Thinking(self._think(now))
        self._found = False

    def step(self, now: Situation, danger: Danger, slices: int) -> Command | None:
        """Over when the item is in a hand, has moved, or cannot be brought anywhere."""
        if now.mine == self.item or now.theirs == self.item or now.delivered[self.item]:
            return None
        if not self._found:
            self._thinking.advance(slices)
            if self._thinking.done:
                self._found = True
                if self._thinking.result is None:
                    self.hopeless = True
                    return None
                self.haul, target = self._thinking.result
                self._approach = Approach(self._ground, self.item, target)
            elif self._approach.way.cost(float(now.pose[0]), float(now.pose[1])) < 24:
                return REST
        elif now.ground() is not self._ground:
            return None
        return self._approach.step(now, danger)

    def _think(self, now: Situation) -> Thought[tuple[Haul, Floats] | None]:
        spec, item_pose = now.item(self.item), now.item_pose(self.item)
        stands = [stand(spec, item_pose, heading) for heading in HEADINGS]
        costs = walk_costs(now, self._ground, now.pose, stands)
        yield
        if min(costs) >= UNREACHED:
            return None
        for margin in (EASY, TIGHT):
            haul = Haul(now.ground((self.item,)), spec, (0.0, ROBOT_RADIUS + GAP + spec.scale, 0.0), margin)
            yield
            yield from solve(haul.field)
            totals = [cost + haul.cost(pose) for cost, pose in zip(costs, stands, strict=True)]
            best = int(np.argmin(totals))
            if totals[best] < UNREACHED:
                return haul, stands[best]
        return None


class Carry:
    """Bringing a small item to its place."""

    def __init__(self, now: Situation, item: int, haul: Haul | None) -> None:
        self.item = item
        self._haul = haul
        self._thinking: Thinking[Haul] | None = None
        self._ground = now.ground() if haul is not None else None

    def step(self, now: Situation, danger: Danger, slices: int) -> Command | None:
        """Over when the hand is empty."""
        if now.mine != self.item:
            return None
        if now.ground() is not self._ground:
            self._ground = now.ground()
            self._thinking = Thinking(self._think(now))
        if self._thinking is not None:
            self._thinking.advance(slices)
            if self._thinking.done:
                self._haul, self._thinking = self._thinking.result, None
        if self._haul is None:
            return REST
        return self._haul.drive(now.pose, now.item_pose(self.item), danger)

    def _think(self, now: Situation) -> Thought[Haul]:
        offset = in_frame(now.pose, now.item_pose(self.item))
        for margin in (EASY, TIGHT):
            haul = Haul(now.ground(), now.item(self.item), offset, margin)
            yield
            yield from solve(haul.field)
            if haul.cost(now.pose) < UNREACHED:
                break
        return haul


class Lift:
    """Taking one end of a heavy item, waiting for the partner at the other end, and carrying it together."""

    def __init__(self, now: Situation, item: int, patience: int) -> None:
        self.item = item
        self.hopeless = False
        self._patience = patience
        self._waited = 0
        self._ground = now.ground(also=(item,))
        self._bare = now.ground((item,))
        self._partner_held = now.theirs == item
        self._approach: Approach | None = None
        self._grips: Thinking[Floats | None] = Thinking(self._think_grip(now))
        self._way: Thinking[PairHaul] | None = None

    def step(self, now: Situation, danger: Danger, slices: int) -> Command | None:
        """Over when the item lies in its goal, cannot be carried, or the partner does not come."""
        if now.mine == self.item and now.theirs == self.item:
            return self._carry(now, slices)
        self._way = None
        if now.mine == self.item:
            return self._wait(now)
        if now.delivered[self.item] and now.theirs != self.item:
            return None
        return self._go(now, danger, slices)

    def _go(self, now: Situation, danger: Danger, slices: int) -> Command | None:
        if (now.theirs == self.item) != self._partner_held or now.ground((self.item,)) is not self._bare:
            return None  # things have changed: think anew
        if self._approach is None:
            self._grips.advance(slices)
            if not self._grips.done:
                return REST
            if self._grips.result is None:
                self.hopeless = True
                return None
            self._approach = Approach(self._ground, self.item, self._grips.result)
        return self._approach.step(now, danger)

    def _wait(self, now: Situation) -> Command:
        self._waited += 1
        if self._waited > self._patience:
            self.hopeless = True
            return Command(0.0, 0.0, grasp=True)
        return REST

    def _carry(self, now: Situation, slices: int) -> Command:
        self._waited = 0
        if self._way is None:
            self._way = Thinking(self._think_way(now))
        self._way.advance(slices)
        if not self._way.done:
            return REST
        commands = self._way.result.drive(now.item_pose(self.item), now.robots)
        return commands[now.seat]

    def _think_way(self, now: Situation) -> Thought[PairHaul]:
        for margin in (0.012, 0.002):
            haul = PairHaul(now.ground(), now.item(self.item), now.item_pose(self.item), now.robots, margin)
            yield
            yield from solve(haul.field)
            if haul.cost(now.item_pose(self.item)) < UNREACHED:
                break
        return haul

    def _think_grip(self, now: Situation) -> Thought[Floats | None]:
        spec, item_pose = now.item(self.item), now.item_pose(self.item)
        stands = [stand(spec, item_pose, heading) for heading in HEADINGS]
        mine = walk_costs(now, self._ground, now.pose, stands)
        yield
        best: tuple[float, Floats] | None = None
        if now.theirs == self.item:
            pairs = self._with_partner(now, stands, mine)
        else:
            theirs = walk_costs(now, self._ground, now.partner, stands)
            yield
            pairs = self._both(now, stands, mine, theirs)
        for _, robots, target in pairs[:5]:
            haul = PairHaul(self._bare, spec, item_pose, robots)
            yield
            yield from solve(haul.field)
            cost = haul.cost(item_pose)
            if cost < UNREACHED and (best is None or cost < best[0]):
                best = (cost, target)
            if best is not None and best[0] < 4 * 60:
                break
        return best[1] if best is not None else None

    def _with_partner(self, now: Situation, stands: list[Floats], mine: list[float]) -> list[tuple[float, Floats, Floats]]:
        pairs = []
        centre = now.item_pose(self.item)
        theirs = heading_of(float(centre[0] - now.partner[0]), float(centre[1] - now.partner[1]))
        for pose, cost in zip(stands, mine, strict=True):
            apart = abs(wrap(float(pose[2]) - theirs))
            if cost < UNREACHED and apart > 1.0:
                robots = np.stack([pose, now.partner] if now.seat == 0 else [now.partner, pose])
                pairs.append((cost + 40.0 * (math.pi - apart), robots, pose))
        return sorted(pairs, key=lambda pair: pair[0])

    def _both(
        self, now: Situation, stands: list[Floats], mine: list[float], theirs: list[float]
    ) -> list[tuple[float, Floats, Floats]]:
        pairs = []
        for number, pose in enumerate(stands):
            other = (number + len(stands) // 2) % len(stands)
            slower = max(mine[number], theirs[other])
            if slower < UNREACHED:
                robots = np.stack([pose, stands[other]] if now.seat == 0 else [stands[other], pose])
                score = round(slower + 0.2 * min(mine[number], theirs[other]))
                blue = number if now.seat == 0 else other  # breaks ties the same way at both ends
                pairs.append((score + blue / 100, robots, pose))
        return sorted(pairs, key=lambda pair: pair[0])
