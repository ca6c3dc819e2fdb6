"""Heavy items: taking one end, waiting for the partner at the other end, and carrying together."""

import itertools
import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from movingout.agents.scripted.carrying import paired_carry
from movingout.agents.scripted.carrying.paired_carry import PairHaul
from movingout.agents.scripted.navigation.geometry import heading_of, wrap
from movingout.agents.scripted.navigation.grasp_stance import stands
from movingout.agents.scripted.navigation.motion_choice import REST, Command, Danger, no_danger
from movingout.agents.scripted.navigation.sliced_planning import Thinking, Thought, solve
from movingout.agents.scripted.navigation.terrain import Terrain, sample, with_robot
from movingout.agents.scripted.navigation.walking_distance import cost_at, walk_lengths
from movingout.agents.scripted.situation import Situation
from movingout.agents.scripted.tasks.approach import NEARLY, Approach, stand_number, walk_costs
from movingout.agents.scripted.tasks.fetch import look_around
from movingout.agents.scripted.traffic import bound, side_prices
from movingout.maps.flood_fill import UNREACHED
from movingout.maps.spec import ROBOT_RADIUS
from movingout.world.state import Floats

GOOD_ENOUGH = 80.0  # quarter ticks: a way together this much longer than a way alone is taken
UNLIKE = 0.7  # rad by which two ways to hold an item differ
APART, COMFORTABLE = 0.255, 0.33  # units between the two holders' centres: at least, and better
FED_UP = 60  # ticks without getting nearer after which a pair lets go, to take the item from other sides
LET_GO = 8  # ticks for which one goes on holding an item that is home when the other one has let go of it
COMFORTABLE_ROOM, CRAMPED = 0.04, 1000.0  # units around a stand; quarter ticks per unit that is missing
_FORGOTTEN = 0.03  # units per tick: who has been near and gone away comes when it turns back
_LOOKED_AT = 12  # grips of which it is known whether who comes first leaves room for the other one
SIDEWAYS = 12.0  # quarter ticks per radian by which two grips are not opposite


class Grips(NamedTuple):
    """Where the two robots hold an item: poses (2, 3) in seat order, and what getting there costs."""

    score: float
    robots: Floats


def grips_for_both(now: Situation, item: int, mine: list[float], theirs: list[float]) -> list[Grips]:
    """Pairs of stands, the quickest to reach first; both minds come to the same order."""
    poses, _ = stands(now.item(item), now.item_pose(item))
    blue_costs, red_costs = (mine, theirs) if now.seat == 0 else (theirs, mine)
    options = []
    for blue, red, sideways, tightness in _pairs(poses.tobytes()):
        slower, quicker = sorted((blue_costs[blue], red_costs[red]))[::-1]
        if slower < UNREACHED:
            options.append((round(slower + 0.2 * quicker + sideways + tightness), blue, red))
    return [Grips(float(score), poses[[blue, red]]) for score, blue, red in sorted(options)]


@lru_cache(maxsize=64)
def _pairs(stands_beside: bytes) -> list[tuple[int, int, float, float]]:
    """Blue's and red's number of stands (n, 3) that both can take at once, and the price of that pair in two parts."""
    poses = np.frombuffer(stands_beside).reshape(-1, 3)
    pairs = []
    for blue, red in itertools.product(range(len(poses)), repeat=2):
        apart = abs(wrap(float(poses[blue, 2] - poses[red, 2])))
        gap = math.dist(poses[blue, :2], poses[red, :2])
        if gap > APART:
            pairs.append((blue, red, SIDEWAYS * (math.pi - apart), _tightness(gap)))
    return pairs


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


def cramped(now: Situation, ground: Terrain, item: int) -> Floats:
    """(32,) the price of stands with so little room that clumsy hands fail there; `ground` is without the item."""
    poses, _ = stands(now.item(item), now.item_pose(item))
    room = sample(ground.clearance, poses[:, 0], poses[:, 1]) - ROBOT_RADIUS
    return CRAMPED * np.maximum(COMFORTABLE_ROOM - room, 0.0)


def grips_beside_partner(now: Situation, item: int, mine: list[float]) -> list[Grips]:
    """Stands that go with the partner's grip, opposite and near ones first."""
    poses, _ = stands(now.item(item), now.item_pose(item))
    centre = now.item_pose(item)
    theirs = heading_of(float(centre[0] - now.partner[0]), float(centre[1] - now.partner[1]))
    options = []
    for number, pose in enumerate(poses):
        apart = abs(wrap(float(pose[2]) - theirs))
        gap = math.dist(pose[:2], now.partner[:2])
        if mine[number] < UNREACHED and gap > APART:
            robots = np.stack([pose, now.partner] if now.seat == 0 else [now.partner, pose])
            score = mine[number] + 2 * SIDEWAYS * (math.pi - apart) + _tightness(gap)
            options.append((score, number, robots))
    return [Grips(score, robots) for score, _, robots in sorted(options, key=lambda option: option[:2])]


class Lift:
    """Taking one end of a heavy item, waiting for the partner at the other end, and carrying it together."""

    def __init__(
        self,
        now: Situation,
        item: int,
        patience: int,
        useless: frozenset[int],
        yields: bool = False,
        side: float = 0.0,
    ) -> None:
        """`useless` are stands that have failed; `side` says from where the player likes to grab."""
        self.item = item
        self.hopeless = False
        self.waited_in_vain = False
        self.given_up: float | None = None  # the heading with which it could not be brought home
        self._useless = useless
        self._patience = patience
        self._yields = yields
        self._side = side
        self._waited = 0
        self._nearest = math.inf
        floor = now.ground(also=(item,))
        self._ground = with_robot(floor, now.partner) if now.theirs == item else floor
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
            self._waited = max(self._waited - 4, 0)
        self._nearest = min(gap, self._nearest + _FORGOTTEN)
        outbid = self._yields and now.theirs >= 0 and now.is_heavy(now.theirs)
        home = bool(now.delivered[self.item])  # who let go of it there thinks that this will do
        patience = min(self._patience, LET_GO) if home else self._patience
        if self._waited > patience or outbid:
            self.hopeless, self.waited_in_vain = True, not (outbid or home)
            return Command(0.0, 0.0, grasp=True)
        return REST

    def _carry(self, now: Situation, slices: int) -> Command:
        self._waited, self._nearest = 0, math.inf
        if self._way is None:
            self._way = Thinking(self._think_way(now))
        self._way.advance(slices)
        if not self._way.done:
            return REST
        if self._way.result.idle_ticks > FED_UP and not now.delivered[self.item]:
            self.given_up = float(now.pose[2])
            return Command(0.0, 0.0, grasp=True)
        return self._way.result.drive(now.item_pose(self.item), now.robots)[now.seat]

    def _think_way(self, now: Situation) -> Thought[PairHaul]:
        look = yield from look_around(now, self.item)
        for margin in (paired_carry.EASY, paired_carry.TIGHT):
            haul = PairHaul(now.ground(), now.item(self.item), now.item_pose(self.item), now.robots, look, margin)
            yield
            yield from solve(haul.field, lambda: haul.cost(now.item_pose(self.item)))  # noqa: B023
            if haul.cost(now.item_pose(self.item)) < UNREACHED:
                break
        return haul

    def _passable(self, now: Situation, options: list[Grips]) -> list[Grips]:
        """Those of the quickest options with which who comes first does not shut the other one out; else all."""
        free = [grips for grips in options[:_LOOKED_AT] if self._leaves_room(now, grips)]
        return [*free, *options[_LOOKED_AT:]] or options

    def _leaves_room(self, now: Situation, grips: Grips) -> bool:
        """Whether the slower robot can still walk to its stand when the quicker one stands at its own."""
        gaps = [self._walk(self._ground, now, seat, grips) for seat in (0, 1)]
        first = 0 if gaps[0] <= gaps[1] else 1
        return self._walk(with_robot(self._ground, grips.robots[first]), now, 1 - first, grips) < UNREACHED

    def _walk(self, ground: Terrain, now: Situation, seat: int, grips: Grips) -> float:
        """Quarter ticks of a seat's way to its grip."""
        robot, stand = now.robots[seat], grips.robots[seat]
        return cost_at(walk_lengths(ground, [(float(robot[0]), float(robot[1]))]), float(stand[0]), float(stand[1]))

    def _think_grips(self, now: Situation) -> Thought[Grips | None]:
        spec, item_pose = now.item(self.item), now.item_pose(self.item)
        walks = walk_costs(now, self._ground, now.pose, self.item, self._useless)
        narrow = cramped(now, self._bare, self.item)
        mine = (np.array(walks) + side_prices(now, self.item, self._side) + narrow).tolist()
        yield
        if now.theirs == self.item:
            options = grips_beside_partner(now, self.item, mine)
        else:
            theirs = (np.array(walk_costs(now, self._ground, now.partner, self.item)) + narrow).tolist()
            yield
            options = grips_for_both(now, self.item, mine, theirs)
        if not options:
            return None
        options = options if now.theirs == self.item else self._passable(now, options)
        self._aim(options[0], now)
        least = bound(now, self.item)
        yield
        best: tuple[float, Grips] | None = None
        varied = unlike(options)
        look = yield from look_around(now, self.item)
        for margin, tried in ((paired_carry.EASY, varied), (paired_carry.TIGHT, varied[:2])):
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
