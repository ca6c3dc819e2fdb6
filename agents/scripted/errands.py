"""What a scripted player can be busy with: fetching, carrying, lifting together. Each errand drives one robot.

An errand's `step` gives the next command, or None when it is over (done or hopeless).
"""

import itertools
import math
from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np

from agents.scripted import pairing
from agents.scripted.driving import REST, Command, Danger, best_move, drive, no_danger, turn_to
from agents.scripted.geometry import heading_of, wrap
from agents.scripted.grasping import GAP, HEADINGS, in_frame, stands, within_reach
from agents.scripted.hauling import Body, Haul, margins
from agents.scripted.lattice import UNREACHED
from agents.scripted.pairing import PairHaul
from agents.scripted.relay import Relay
from agents.scripted.situation import Situation
from agents.scripted.storage import Places, places
from agents.scripted.terrain import Terrain, sample
from agents.scripted.thinking import Thinking, Thought, solve
from agents.scripted.traffic import around, aside, bound, partners_way, with_partner
from agents.scripted.walking import Mask, Way, cost_at, walk_field
from maps.shapes import circumradius
from maps.spec import ROBOT_RADIUS
from world.state import Floats

GOOD_ENOUGH = 80.0  # quarter ticks: a way together this much longer than a way alone is taken
APART, COMFORTABLE = 0.255, 0.33  # units between the two holders' centres: at least, and better
SIDEWAYS = 12.0  # quarter ticks per radian by which two grips are not opposite
HONEST = 350.0  # quarter ticks: a dearer way may come from a bad place to put the item down
WORTH_SQUEEZING = 100.0  # quarter ticks that a way with hardly any room must save
_FAR_AHEAD = 150  # cells of the partner's way home that one had better not meet it on
UNLIKE = 0.7  # rad by which two ways to hold an item differ
NEARLY = 0.09  # units from its stand at which a planned grip still is what was planned
NEAR = 0.05  # units from its stand at which a robot turns to the item


class Errand(Protocol):
    """One thing to do."""

    item: int

    def step(self, now: Situation, danger: Danger, slices: int) -> Command | None: ...


def walk_costs(
    now: Situation, ground: Terrain, position: Floats, item: int, useless: frozenset[int] = frozenset()
) -> list[float]:
    """Quarter ticks on foot to each of the 32 stands beside an item; UNREACHED where one cannot stand or grab.

    `useless` are stands from which the hand did not reach the item, against expectation.
    """
    field = walk_field(ground, [(float(position[0]), float(position[1]))])
    places, useful = stands(now.item(item), now.item_pose(item))
    room = sample(ground.clearance, places[:, 0], places[:, 1]) >= ROBOT_RADIUS - 0.006
    return [
        cost_at(field, x, y) if fits and number not in useless else float(UNREACHED)
        for number, ((x, y, _), fits) in enumerate(zip(places.tolist(), room & useful, strict=True))
    ]


def look_around(now: Situation, ground: Terrain, item: int) -> Thought[Places]:
    """What the places for an item are worth, with everything else that is still to come."""
    spec = now.item(item)
    return places(ground, circumradius(spec.shape, spec.scale), now.outlook(item))


class Approach:
    """Walking to a stand beside an item and closing the hand."""

    def __init__(self, ground: Terrain, item: int, target: Floats, shunned: Mask | None = None) -> None:
        self.item = item
        self.target = target
        self.ground = ground
        self.way = Way(ground, [(float(target[0]), float(target[1]))], shunned)

    def step(self, now: Situation, danger: Danger) -> Command:
        """The next command; with a grasp as soon as the hand reaches the item."""
        pose, goal = now.pose, now.item_pose(self.item)
        to_item = heading_of(float(goal[0] - pose[0]), float(goal[1] - pose[1]))
        off = wrap(to_item - float(pose[2]))
        gap = math.hypot(float(pose[0] - self.target[0]), float(pose[1] - self.target[1]))
        if self._well_placed(now, gap) and within_reach(now.item(self.item), goal, pose):
            return Command(0.3, float(pose[2]), grasp=True)
        if gap < NEAR or self.way.cost(float(pose[0]), float(pose[1])) <= 2.0:
            gently = 0.35 if now.is_heavy(self.item) else 1.0  # a hard push slides along the item
            return drive(to_item, gently) if abs(off) < 0.3 else turn_to(to_item)
        command, _ = best_move(pose, lambda moves: self.way.costs(moves) + danger(moves))
        return command

    def _well_placed(self, now: Situation, gap: float) -> bool:
        """A small item may be taken from anywhere; the grips on a heavy one were planned."""
        return not now.is_heavy(self.item) or (gap < NEARLY and abs(wrap(float(now.pose[2] - self.target[2]))) < 0.35)


def stand_number(target: Floats) -> int:
    """Which of the 32 stands a pose is."""
    return round(float(target[2]) / (2 * math.pi / len(HEADINGS))) % len(HEADINGS)


class Fetch:
    """Going to a small item; knows on the way how it will be carried, and so from which side to take it."""

    def __init__(
        self, now: Situation, item: int, useless: frozenset[int], meeting: Relay | None, tidying: bool = False
    ) -> None:
        """With `meeting` it is going to be handed over there; with `tidying` it may lie in a goal already."""
        self._tidying = tidying
        self._theirs = -1
        self.item = item
        self.meeting = meeting
        self._useless = useless
        self.haul: Haul | None = None
        self.hopeless = False
        self._ground = now.ground()
        self._item_pose = now.item_pose(item)
        goal = now.item_pose(item)
        self._approach = Approach(self._ground, item, np.array([goal[0], goal[1], 0.0]))
        self._thinking: Thinking[tuple[Haul, Floats] | None] = Thinking(self._think(now))
        self._found = False

    @property
    def stand(self) -> int:
        """The stand it is about to use, -1 while undecided."""
        return stand_number(self._approach.target) if self._found else -1

    def go_around(self, now: Situation) -> None:
        """Look for a way around the partner; stay on the old one where there is none."""
        other = Approach(with_partner(self._ground, now.partner), self.item, self._approach.target)
        if other.way.cost(float(now.pose[0]), float(now.pose[1])) < UNREACHED:
            self._approach = other

    def step(self, now: Situation, danger: Danger, slices: int) -> Command | None:
        """Over when the item is in a hand, has moved, or cannot be brought anywhere."""
        if now.mine == self.item or now.theirs == self.item or (now.delivered[self.item] and not self._tidying):
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
        elif now.theirs != self._theirs:
            self._theirs = now.theirs
            if now.theirs >= 0 and not now.is_heavy(now.theirs):
                self._take_another_way(now)
        return self._approach.step(now, danger)

    def _take_another_way(self, now: Situation) -> None:
        """Keep off the way on which the partner brings its item home, where that is no great detour."""
        way = partners_way(now, -1, _FAR_AHEAD)
        self._approach = Approach(self._ground, self.item, self._approach.target, around(way))

    def _think(self, now: Situation) -> Thought[tuple[Haul, Floats] | None]:
        spec, item_pose = now.item(self.item), now.item_pose(self.item)
        poses, _ = stands(spec, item_pose)
        costs = walk_costs(now, self._ground, now.pose, self.item, self._useless)
        yield
        if min(costs) >= UNREACHED:
            return None
        offset = (0.0, ROBOT_RADIUS + GAP + spec.scale, 0.0)
        best: tuple[float, Haul, Floats] | None = None
        ground = now.ground((self.item,))
        look = yield from look_around(now, ground, self.item)
        for margin in margins(now.map):
            haul = Haul(ground, spec, offset, look, margin, self.meeting)
            yield
            reachable = [(cost, pose) for cost, pose in zip(costs, poses, strict=True) if cost < UNREACHED]
            yield from solve(haul.field, lambda: min(cost + haul.cost(pose) for cost, pose in reachable))  # noqa: B023
            totals = [cost + haul.cost(pose) for cost, pose in zip(costs, poses, strict=True)]
            number = int(np.argmin(totals))
            if best is None or totals[number] < best[0] - WORTH_SQUEEZING:
                best = (totals[number], haul, poses[number])
            if best[0] < HONEST:
                break
        return best[1:] if best is not None and best[0] < UNREACHED else None


class Carry:
    """Bringing a small item to its place."""

    def __init__(self, now: Situation, item: int, haul: Haul | None, meeting: Relay | None) -> None:
        """`haul` is the plan made while fetching it, if it still serves."""
        self.item = item
        self.meeting = meeting
        self._haul = haul
        self._thinking: Thinking[Haul] | None = None
        self._ground = now.ground() if haul is not None else None

    def step(self, now: Situation, danger: Danger, slices: int) -> Command | None:
        """Over when the hand is empty."""
        if now.mine != self.item:
            return None
        if now.ground() is not self._ground:
            self._ground = now.ground()
            self._thinking = Thinking(self._think(now, self._ground))
        if self._thinking is not None:
            self._thinking.advance(slices)
            if self._thinking.done:
                self._haul, self._thinking = self._thinking.result, None
        if self._haul is None:
            return REST
        return self._haul.drive(now.pose, now.item_pose(self.item), danger)

    def go_around(self, now: Situation) -> None:
        """Plan anew with the partner as something that stands there."""
        self._thinking = Thinking(self._think(now, with_partner(now.ground(), now.partner)))

    def _think(self, now: Situation, ground: Terrain) -> Thought[Haul]:
        offset = in_frame(now.pose, now.item_pose(self.item))
        best: tuple[float, Haul] | None = None
        look = yield from look_around(now, ground, self.item)
        for margin in margins(now.map):
            haul = Haul(ground, now.item(self.item), offset, look, margin, self.meeting)
            yield
            yield from solve(haul.field, lambda: haul.cost(now.pose))  # noqa: B023
            cost = haul.cost(now.pose)
            if best is None or cost < best[0] - WORTH_SQUEEZING:
                best = (cost, haul)
            if best[0] < HONEST:
                break
        assert best is not None  # there are margins
        return best[1]


class Grips(NamedTuple):
    """Where the two robots hold an item: poses (2, 3) in seat order, and what getting there costs."""

    score: float
    robots: Floats


def grips_for_both(now: Situation, item: int, mine: list[float], theirs: list[float]) -> list[Grips]:
    """Pairs of stands, the quickest to reach first; both minds come to the same order."""
    places, _ = stands(now.item(item), now.item_pose(item))
    blue_costs, red_costs = (mine, theirs) if now.seat == 0 else (theirs, mine)
    options = []
    for blue, red in itertools.product(range(len(places)), repeat=2):
        slower, quicker = sorted((blue_costs[blue], red_costs[red]))[::-1]
        apart = abs(wrap(float(places[blue, 2] - places[red, 2])))
        gap = math.dist(places[blue, :2], places[red, :2])
        if slower < UNREACHED and gap > APART:
            score = round(slower + 0.2 * quicker + SIDEWAYS * (math.pi - apart) + _tightness(gap))
            options.append((score, blue, red))
    return [Grips(float(score), np.stack([places[blue], places[red]])) for score, blue, red in sorted(options)]


def unlike(options: list[Grips], most: int = 6) -> list[Grips]:
    """The first option, and the next ones that differ from those before in at least one hand."""
    chosen: list[Grips] = []
    for option in options:
        turns = (np.abs(_wrapped(option.robots[:, 2] - other.robots[:, 2])).max() for other in chosen)
        if all(turn > UNLIKE for turn in turns):
            chosen.append(option)
        if len(chosen) == most:
            break
    return chosen


def _wrapped(angles: Floats) -> Floats:
    return np.asarray((angles + math.pi) % (2 * math.pi) - math.pi)


def _tightness(gap: float) -> float:
    """The price of two holders so near to each other that one may keep the other from its stand."""
    return max(COMFORTABLE - gap, 0.0) * 1000.0


def grips_beside_partner(now: Situation, item: int, mine: list[float]) -> list[Grips]:
    """Stands that go with the partner's grip, opposite and near ones first."""
    places, _ = stands(now.item(item), now.item_pose(item))
    centre = now.item_pose(item)
    theirs = heading_of(float(centre[0] - now.partner[0]), float(centre[1] - now.partner[1]))
    options = []
    for number, pose in enumerate(places):
        apart = abs(wrap(float(pose[2]) - theirs))
        gap = math.dist(pose[:2], now.partner[:2])
        if mine[number] < UNREACHED and gap > APART:
            robots = np.stack([pose, now.partner] if now.seat == 0 else [now.partner, pose])
            score = mine[number] + 2 * SIDEWAYS * (math.pi - apart) + _tightness(gap)
            options.append((score, number, robots))
    return [Grips(score, robots) for score, _, robots in sorted(options, key=lambda option: option[:2])]


class Lift:
    """Taking one end of a heavy item, waiting for the partner at the other end, and carrying it together."""

    def __init__(self, now: Situation, item: int, patience: int, useless: frozenset[int]) -> None:
        self.item = item
        self.hopeless = False
        self._useless = useless
        self._patience = patience
        self._waited = 0
        self._nearest = math.inf
        floor = now.ground(also=(item,))
        self._ground = with_partner(floor, now.partner) if now.theirs == item else floor
        self._bare = now.ground((item,))
        self._partner_grip = now.partner.copy() if now.theirs == item else None
        self._approach: Approach | None = None
        self._decided = False
        self._grips: Thinking[Grips | None] = Thinking(self._think_grips(now))
        self._way: Thinking[PairHaul] | None = None

    @property
    def stand(self) -> int:
        """The stand it is about to use, -1 while undecided."""
        return stand_number(self._approach.target) if self._approach and self._decided else -1

    def step(self, now: Situation, danger: Danger, slices: int) -> Command | None:
        """Over when the item lies in its goal, cannot be carried, or the partner does not come."""
        if now.mine == self.item and now.theirs == self.item:
            return self._carry(now, slices)
        self._way = None
        if now.mine == self.item:
            return self._wait(now)
        if self.hopeless or (now.delivered[self.item] and now.theirs != self.item) or self._outdated(now):
            return None
        return self._go(now, danger, slices)

    def _outdated(self, now: Situation) -> bool:
        """Whether the floor or the partner's grip is not what the own grip was chosen for."""
        if now.ground((self.item,)) is not self._bare:
            return True
        if now.theirs != self.item:
            return False
        return self._partner_grip is None or bool(np.hypot(*(now.partner - self._partner_grip)[:2]) > NEARLY)

    def _go(self, now: Situation, danger: Danger, slices: int) -> Command | None:
        if not self._decided:
            self._grips.advance(slices)
            if self._grips.done:
                if self._grips.result is None:
                    self.hopeless = True
                    return None
                self._decided = True
                self._aim(self._grips.result, now)
        if self._approach is None:
            return REST
        if not self._decided and self._approach.way.cost(float(now.pose[0]), float(now.pose[1])) < 12:
            return REST
        return self._approach.step(now, danger if now.theirs != self.item else no_danger)

    def _aim(self, grips: Grips, now: Situation) -> None:
        """Walk to the own one of two grips."""
        self._partner_grip = grips.robots[1 - now.seat]
        target = grips.robots[now.seat]
        if self._approach is None or (self._approach.target != target).any():
            self._approach = Approach(self._ground, self.item, target)

    def _wait(self, now: Situation) -> Command:
        """Hold on, and lose patience only while the partner does not come nearer."""
        gap = float(np.hypot(*(now.partner - now.item_pose(self.item))[:2]))
        self._waited += 1
        if gap < self._nearest - 0.02:
            self._nearest = gap
            self._waited = max(self._waited - 4, 0)
        if self._waited > self._patience:
            self.hopeless = True
            return Command(0.0, 0.0, grasp=True)
        return REST

    def _carry(self, now: Situation, slices: int) -> Command:
        self._waited, self._nearest = 0, math.inf
        if self._way is None:
            self._way = Thinking(self._think_way(now))
        self._way.advance(slices)
        if not self._way.done:
            return REST
        return self._way.result.drive(now.item_pose(self.item), now.robots)[now.seat]

    def _think_way(self, now: Situation) -> Thought[PairHaul]:
        look = yield from look_around(now, now.ground(), self.item)
        for margin in (pairing.EASY, pairing.TIGHT):
            haul = PairHaul(
                now.ground(), now.item(self.item), now.item_pose(self.item), now.robots, look, margin
            )
            yield
            yield from solve(haul.field, lambda: haul.cost(now.item_pose(self.item)))  # noqa: B023
            if haul.cost(now.item_pose(self.item)) < UNREACHED:
                break
        return haul

    def _think_grips(self, now: Situation) -> Thought[Grips | None]:
        spec, item_pose = now.item(self.item), now.item_pose(self.item)
        mine = walk_costs(now, self._ground, now.pose, self.item, self._useless)
        yield
        if now.theirs == self.item:
            options = grips_beside_partner(now, self.item, mine)
        else:
            theirs = walk_costs(now, self._ground, now.partner, self.item)
            yield
            options = grips_for_both(now, self.item, mine, theirs)
        if not options:
            return None
        self._aim(options[0], now)
        least = bound(now, self.item)
        yield
        best: tuple[float, Grips] | None = None
        varied = unlike(options)
        look = yield from look_around(now, self._bare, self.item)
        for margin, tried in ((pairing.EASY, varied), (pairing.TIGHT, varied[:2])):
            for grips in tried:
                haul = PairHaul(self._bare, spec, item_pose, grips.robots, look, margin)
                yield
                yield from solve(haul.field, lambda: haul.cost(item_pose))  # noqa: B023
                cost = haul.cost(item_pose)
                if cost < UNREACHED and (best is None or cost + grips.score < best[0]):
                    best = (cost + grips.score, grips)
                if cost < least + GOOD_ENOUGH:
                    return grips
            if best is not None:
                return best[1]
        return None


class WalkTo:
    """Going somewhere to wait there."""

    item = -1
    hopeless = False

    def __init__(self, now: Situation, place: tuple[float, float], until: int) -> None:
        self.until = until
        self._way = Way(now.ground(), [place])

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
        self, now: Situation, way: Floats, until: int, needed: Callable[[Situation], bool] | None = None
    ) -> None:
        """It lasts until a tick, or as long as it is `needed` where that can be said."""
        self.until = until
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
        if here < 1.5:
            return REST
        return body.move(now.pose, danger)

    def _think(self, now: Situation, way: Floats) -> Thought[Body]:
        body = aside(now, way)
        yield
        yield from solve(body.field, lambda: body.cost(now.pose))
        return body
