"""The scripted partner: looks, decides what to be busy with, and drives."""

import math
from random import Random

import numpy as np

from agents.base import ActionChunk, EpisodeInfo, Observation
from agents.scripted.driving import HORIZON, REST, Command
from agents.scripted.errands import Carry, Errand, Fetch, Lift
from agents.scripted.lattice import UNREACHED
from agents.scripted.situation import Situation
from agents.scripted.style import Style, varied
from agents.scripted.terrain import Terrain
from maps.spec import ROBOT_RADIUS
from world.state import Floats

SLICES_PER_TICK = 2


class ScriptedAgent:
    """Plays sensibly with anybody on any map; deterministic given its seed and style."""

    execute_rows = 1

    def __init__(self, seed: int = 0) -> None:
        self.style: Style = varied(seed)
        self.seed = seed
        self.detail: dict[str, object] = {}

    def reset(self, episode: EpisodeInfo) -> None:
        self._episode = episode
        self._random = Random(f"{self.seed}/{episode.seed}/{episode.seat}")
        self._errand: Errand | None = None
        self._hopeless: dict[int, Terrain] = {}
        self._tired: dict[int, int] = {}

    def act(self, observation: Observation) -> ActionChunk:
        now = Situation(self._episode.map, observation.state, observation.seat)
        command = self._command(now)
        self.detail = {"errand": type(self._errand).__name__, "item": self._errand.item if self._errand else -1}
        row = [command.distance, math.cos(command.heading), math.sin(command.heading), float(command.grasp)]
        return np.array([row])

    def _command(self, now: Situation) -> Command:
        danger = self._danger(now)
        for _ in range(2):
            self._keep_or_choose(now)
            if self._errand is None:
                return REST
            command = self._errand.step(now, danger, SLICES_PER_TICK)
            if command is not None:
                return command
            self._end(now)
        return REST

    def _end(self, now: Situation) -> None:
        if getattr(self._errand, "hopeless", False):
            self._hopeless[self._errand.item] = now.ground((self._errand.item,))
            self._tired[self._errand.item] = now.tick + 60
        self._errand = None

    def _keep_or_choose(self, now: Situation) -> None:
        errand = self._errand
        if now.mine >= 0:
            if now.is_heavy(now.mine):
                if not (isinstance(errand, Lift) and errand.item == now.mine):
                    self._errand = Lift(now, now.mine, self.style.patience)
            elif not (isinstance(errand, Carry) and errand.item == now.mine):
                known = errand.haul if isinstance(errand, Fetch) and errand.item == now.mine else None
                self._errand = Carry(now, now.mine, known)
            return
        helping = now.theirs >= 0 and now.is_heavy(now.theirs) and self._possible(now, now.theirs)
        if helping and not (isinstance(errand, Lift) and errand.item == now.theirs):
            self._errand = Lift(now, now.theirs, self.style.patience)
        elif errand is None:
            self._errand = self._choose(now)

    def _possible(self, now: Situation, item: int) -> bool:
        if self._tired.get(item, 0) > now.tick:
            return False
        return self._hopeless.get(item) is not now.ground((item,))

    def _choose(self, now: Situation) -> Errand | None:
        open_items = [item for item in now.waiting if self._possible(now, item)]
        if not open_items:
            return None
        poses = [now.item_pose(item) for item in open_items]
        ground = now.ground()
        mine = self._to_items(ground, now.pose, poses)
        theirs = self._to_items(ground, now.partner, poses)
        cost = dict(zip(open_items, mine, strict=True))
        their_cost = dict(zip(open_items, theirs, strict=True))
        heavies = [item for item in open_items if now.is_heavy(item) and cost[item] < UNREACHED]
        smalls = [item for item in open_items if not now.is_heavy(item) and cost[item] < UNREACHED]
        if heavies and now.theirs < 0 and (self.style.heavy_first or not smalls):
            return Lift(now, min(heavies, key=lambda item: (round(cost[item] + their_cost[item]), item)), self.style.patience)
        if smalls:
            return Fetch(now, self._divide(smalls, cost, their_cost, now))
        if heavies:
            return Lift(now, min(heavies, key=cost.__getitem__), self.style.patience)
        return None

    def _divide(self, smalls: list[int], mine: dict[int, float], theirs: dict[int, float], now: Situation) -> int:
        if len(smalls) == 1 or now.theirs >= 0:
            return min(smalls, key=lambda item: (mine[item], item))
        pairs = [(one, other) for one in smalls for other in smalls if one != other]
        return min(pairs, key=lambda pair: (round(mine[pair[0]] + theirs[pair[1]]), mine[pair[0]]))[0]

    def _to_items(self, ground: Terrain, position: Floats, poses: list[Floats]) -> list[float]:
        from agents.scripted.terrain import cell_of
        from agents.scripted.walking import grid_of, walk_field
        grid = grid_of(walk_field(ground, [(float(position[0]), float(position[1]))]))
        costs = []
        for pose in poses:
            row, column = cell_of(float(pose[0]), float(pose[1]))
            window = grid[max(row - 10, 0) : row + 11, max(column - 10, 0) : column + 11]
            costs.append(float(window.min()))
        return costs

    def _danger(self, now: Situation):
        partner = now.partner
        velocity = now.state.robot_velocities[1 - now.seat][:2] * 0.1
        steps = np.arange(1, HORIZON + 1)
        px = partner[0] + velocity[0] * steps
        py = partner[1] + velocity[1] * steps
        together = now.mine >= 0 and now.mine == now.theirs

        def danger(moves: Floats) -> Floats:
            if together:
                return np.zeros(len(moves))
            gap = np.hypot(moves[..., 0] - px, moves[..., 1] - py)
            overlap = np.maximum(2 * ROBOT_RADIUS + 0.02 - gap, 0.0)
            return np.asarray((overlap * 600.0).max(axis=1))

        return danger
