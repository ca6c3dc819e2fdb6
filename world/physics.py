"""The simulated world: one map, advanced tick by tick. Deterministic to the bit; no clock, no randomness."""

import math
from array import array
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np
import numpy.typing as npt
from pymunk._chipmunk_cffi import lib  # the engine without its Python wrapper: the same numbers, faster

from movingout.maps.spec import SEAT_COLOURS, MapSpec, Pose
from movingout.world import constants as c
from movingout.world.bodies import build_bodies, move_bodies
from movingout.world.drive import drive_command
from movingout.world.errors import ActionError, WorldError
from movingout.world.grab import hold, let_go, toggle_hand
from movingout.world.scoring import goal_boxes, is_delivered
from movingout.world.state import Floats, WorldState

if TYPE_CHECKING:
    from PIL.Image import Image

_ACTIONS_SHAPE = (2, 3)
_TICK_BYTES = 2 * 3 * 8

Actions = npt.NDArray[Any] | Sequence[Sequence[float]]

_BLUE, _RED, _ITEMS = 0, 1, 2  # rows of the pose tables; items begin at row 2


@dataclass(frozen=True, slots=True)
class Snapshot:
    """A moment of an episode: the map and every action so far. Small, picklable, exact on any machine."""

    map: MapSpec
    actions: bytes  # ticks x 2 x 3 float64

    @property
    def tick(self) -> int:
        return len(self.actions) // _TICK_BYTES


def _halves(poses: int) -> tuple[tuple[int, ...], ...]:
    """Sub-steps of a tick's two halves, cut where one of `poses` evenly spaced poses is due."""
    due = range(0, c.SUB_STEPS + 1, c.SUB_STEPS // poses)
    cuts = sorted({*due, c.SUB_STEPS_PER_HALF})
    middle = cuts.index(c.SUB_STEPS_PER_HALF)
    return tuple(tuple(b - a for a, b in pairwise(half)) for half in (cuts[: middle + 1], cuts[middle:]))


_SAMPLED_HALVES = _halves(c.POSES_PER_TICK)  # (4, 4, 2), (2, 4, 4)


class World:
    """The simulated world of one map; `step` is the one way to advance time.

    The same map and actions give the same floats. `record_sub_poses=False` is for headless runs: it
    skips reading poses within a tick, and `sub_poses` then raises. Fewer `sub_steps`, an even number, are for looking
    ahead: nearly as exact and cheaper; what is played has all of them.
    """

    def __init__(self, map_spec: MapSpec, *, record_sub_poses: bool = True, sub_steps: int = c.SUB_STEPS) -> None:
        """Raises WorldError."""
        if not isinstance(map_spec, MapSpec):
            raise WorldError(f'a world is made of a map, as in World(load_map("HandOff")), not of {map_spec!r:.80}')
        if sub_steps != c.SUB_STEPS and (record_sub_poses or sub_steps < 2 or sub_steps % 2):
            raise WorldError(f"a tick of a world without sub-poses has an even number of engine steps, not {sub_steps}")
        self.map = map_spec
        self._record_sub_poses = record_sub_poses
        half = sub_steps // 2
        self._halves = _SAMPLED_HALVES if record_sub_poses else ((half,), (half,))
        self._sub_step_s = c.HALF_TICK_SECONDS / half
        self._goals = goal_boxes(map_spec)
        self._build()

    @classmethod
    def from_state(cls, map_spec: MapSpec, state: WorldState) -> "World":
        """A world that looks like `state`, at tick 0 and without sub-poses, to simulate on from what is seen.

        Close to the world that the state is of, not equal to it: contact impulses and the angle of the steering
        bodies are not seen, and an item in a hand is held where it is. Its snapshots are of a map of its own.
        """
        world = cls(map_spec, record_sub_poses=False)
        world.place(state)
        return world

    def place(self, state: WorldState) -> None:
        """Be what `from_state` returns for the same map; six times faster than a new world."""
        blue, red = (Pose(*row) for row in state.robot_poses.tolist())
        poses = [Pose(*row) for row in state.item_poses.tolist()]
        items = tuple(replace(item, pose=pose) for item, pose in zip(self.map.items, poses, strict=True))
        self.map = replace(self.map, robots=(blue, red), items=items)
        for seat, robot in enumerate(self._bodies.robots):
            if robot.item is not None:
                let_go(self._bodies, seat)
        move_bodies(self._bodies, state.robot_poses.tolist(), state.item_poses.tolist())
        for seat, (vx, vy, turning) in enumerate(state.robot_velocities.tolist()):
            if state.held[seat] >= 0:
                hold(self._bodies, seat, int(state.held[seat]))
            robot = self._bodies.robots[seat]
            robot.body.velocity, robot.body.angular_velocity = (vx, vy), turning
            lib.cpBodySetVelocity(robot.control, (vx, vy))  # red drives on until its half of the tick
        self._begin()
        self._velocities = array("d", state.robot_velocities.ravel().tolist())
        self._held = state.held.tolist()

    def _build(self) -> None:
        self._bodies = build_bodies(self.map)
        self._space = self._bodies.space._space
        self._handles = [robot.handle for robot in self._bodies.robots] + [item.handle for item in self._bodies.items]
        self._begin()

    def _begin(self) -> None:
        """Be at tick 0, with the bodies as they are."""
        self._control_angles = [pose.angle for pose in self.map.robots]
        self._log = array("d")
        self._failed = False
        self._held = [-1, -1]
        self._velocities = array("d", bytes(6 * 8))  # of blue and red: vx, vy, angular
        self._delivered = [False] * len(self.map.items)
        self._delivery_stale = set(
            range(len(self.map.items))
        )  # indices of items whose delivery has to be checked again
        # Poses of blue, red and the items, three numbers a row: of the last tick, and as it goes on.
        self._live = array("d", bytes(3 * 8 * len(self._handles)))
        self._read_poses(range(len(self._handles)))
        self._poses = self._live[:]
        self._sub_poses = self._poses * c.POSES_PER_TICK
        self._moving = [_BLUE, _RED]  # rows that may have changed in this tick

    @property
    def tick(self) -> int:
        """Number of steps made."""
        return len(self._log) // 6

    def step(self, actions: Actions) -> None:
        """Advance by one tick (100 ms).

        `actions` is (2, 3): for blue and red distance (nominally [-1, 1], not clipped), heading [rad] and
        grasp toggle (above 0.5 toggles). ActionError leaves the world as it was. WorldError means that the
        numbers were lost (wild actions can do that): state() keeps the last good tick, stepping is over.
        """
        rows = _checked(actions)
        if self._failed:
            raise WorldError("this world has failed in an earlier step; make a new World or restore a snapshot")
        self._stop_held_items()
        samples = array("d")
        for seat, (distance, heading, grasp) in enumerate(rows):
            self._steer(seat, distance, heading)
            if grasp > 0.5:
                toggle_hand(self._bodies, seat)
                self._note_moving()
            self._advance(self._halves[seat], samples)
        self._finish(samples)
        self._log.extend(rows[0] + rows[1])

    def state(self) -> WorldState:
        """The world after the last tick, as copies."""
        poses = np.array(self._poses).reshape(-1, 3)
        velocities = np.array(self._velocities).reshape(2, 3)
        return WorldState(self.tick, poses[:_ITEMS], velocities, np.array(self._held, dtype=np.int64), poses[_ITEMS:])

    def delivered(self) -> npt.NDArray[np.bool_]:
        """(N,) which items are delivered now (see movingout.world.scoring)."""
        return np.array(self._delivery_flags(), dtype=np.bool_)

    def score(self) -> float:
        """The official global_score: delivered items / items, in [0, 1]."""
        flags = self._delivery_flags()
        return sum(flags) / len(flags)

    def sub_poses(self) -> Floats:
        """(5, 2 + N, 3) x, y, angle of robots and items, every 20 ms of the last tick; the last row is now.

        Raises WorldError for a world that records none.
        """
        if not self._record_sub_poses:
            raise WorldError("this world records no sub-poses; make it with World(map, record_sub_poses=True)")
        return np.array(self._sub_poses).reshape(c.POSES_PER_TICK, -1, 3)

    def render(self, side: int = 360) -> "Image":
        """The world now as a Pillow picture of `side` x `side` pixels, which notebooks show."""
        from movingout.world.raster import picture  # headless runs do without Pillow

        return picture(self.map, self.state(), side=side)

    def snapshot(self) -> Snapshot:
        """This moment, to come back to with `restore`, here or in another World of the same map."""
        return Snapshot(self.map, self._log.tobytes())

    def restore(self, snapshot: Snapshot) -> None:
        """Be at the snapshot's moment again, exact to the bit, by simulating its actions again.

        Costs a step for every tick: of the whole episode, or of what is new when the snapshot lies ahead of
        this world on the same actions. Copying the engine's space instead is not exact (it loses impulses).
        Raises WorldError for one of another map.
        """
        if snapshot.map != self.map:
            raise WorldError(f"this snapshot is of map {snapshot.map.name!r}, this world of {self.map.name!r}")
        done = self._log.tobytes()
        if self._failed or not snapshot.actions.startswith(done):
            self._build()
            done = b""
        for actions in np.frombuffer(snapshot.actions[len(done) :]).reshape(-1, *_ACTIONS_SHAPE):
            self.step(actions)

    def __reduce__(self) -> NoReturn:
        """The engine's space cannot be copied exactly. Raises WorldError for copy.deepcopy and pickle."""
        raise WorldError("a World is not copied or pickled; keep its snapshot(), and restore() it in another World")

    def _delivery_flags(self) -> list[bool]:
        for index in self._delivery_stale:
            start = 3 * (_ITEMS + index)
            x, y, angle = self._poses[start : start + 3]
            self._delivered[index] = is_delivered(self.map.items[index], (x, y, angle), self._goals)
        self._delivery_stale.clear()
        return self._delivered

    def _stop_held_items(self) -> None:
        self._moving = [_BLUE, _RED]
        self._note_moving()
        for row in self._moving[_ITEMS:]:
            body = self._bodies.items[row - _ITEMS].body
            body.velocity = (0.0, 0.0)
            body.angular_velocity = 0.0

    def _note_moving(self) -> None:
        for robot in self._bodies.robots:
            if robot.item is not None and _ITEMS + robot.item.index not in self._moving:
                self._moving.append(_ITEMS + robot.item.index)

    def _steer(self, seat: int, distance: float, heading: float) -> None:
        robot = self._bodies.robots[seat]
        if distance == 0:
            robot.body.velocity = (0.0, 0.0)
        target, vx, vy = drive_command(
            distance,
            heading,
            angle=lib.cpBodyGetAngle(robot.handle),
            control_angle=self._control_angles[seat],
            hand=robot.hand,
        )
        self._control_angles[seat] = target
        lib.cpBodySetAngle(robot.control, target)
        lib.cpBodySetVelocity(robot.control, (vx, vy))

    def _advance(self, blocks: tuple[int, ...], samples: "array[float]") -> None:
        space, engine_step, dt = self._space, lib.cpSpaceStep, self._sub_step_s
        for block, sub_steps in enumerate(blocks):
            if block:
                self._read_poses(self._moving)
                samples.extend(self._live)
            for _ in range(sub_steps):
                engine_step(space, dt)

    def _read_poses(self, rows: Iterable[int]) -> None:
        live, handles = self._live, self._handles
        for row in rows:
            position = lib.cpBodyGetPosition(handles[row])
            live[3 * row] = position.x
            live[3 * row + 1] = position.y
            live[3 * row + 2] = lib.cpBodyGetAngle(handles[row])

    def _finish(self, samples: "array[float]") -> None:
        """Take over the finished tick, unless the engine has lost its numbers."""
        self._read_poses(self._moving)
        velocities = array("d", _velocity(self._handles[_BLUE]) + _velocity(self._handles[_RED]))
        if not math.isfinite(sum(self._live) + sum(velocities)):
            self._failed = True
            raise WorldError(_lost_numbers(self.tick + 1, self._live))
        self._velocities = velocities
        self._poses = self._live[:]
        self._held = [-1 if robot.item is None else robot.item.index for robot in self._bodies.robots]
        for row in self._moving[_ITEMS:]:
            self._delivery_stale.add(row - _ITEMS)
        if self._record_sub_poses:
            samples.extend(self._live)
            self._sub_poses = samples


def _velocity(handle: Any) -> tuple[float, float, float]:
    velocity = lib.cpBodyGetVelocity(handle)
    return velocity.x, velocity.y, lib.cpBodyGetAngularVelocity(handle)


def _checked(actions: Actions) -> list[list[float]]:
    """The actions as two rows of three finite floats."""
    try:
        table = np.asarray(actions, dtype=np.float64)
    except (TypeError, ValueError, RuntimeError) as error:  # the last for tensors of torch that require grad
        raise ActionError(f"actions are (2, 3) numbers: distance, heading, grasp of blue and red; {error}") from error
    if table.shape != _ACTIONS_SHAPE:
        raise ActionError(f"actions are (2, 3): distance, heading, grasp of blue and red; got shape {table.shape}")
    rows: list[list[float]] = table.tolist()
    if not math.isfinite(sum(rows[0]) + sum(rows[1])):  # or huge: look closer
        for colour, row in zip(SEAT_COLOURS, rows, strict=True):
            if not all(map(math.isfinite, row)):
                raise ActionError(f"{colour}'s action {row} is not finite; distance, heading and grasp must be numbers")
    return rows


def _lost_numbers(tick: int, poses: "array[float]") -> str:
    return (
        f"the physics lost its numbers in tick {tick} (blue at {poses[0]}, {poses[1]}, red at {poses[3]}, {poses[4]}); "
        "the episode cannot go on, start a new one"
    )
