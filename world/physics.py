"""The world: one map, advanced tick by tick. Deterministic to the bit; it knows no clock and no randomness."""

import math
from array import array
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from pymunk._chipmunk_cffi import lib  # the engine without its Python wrapper: the same numbers, sooner

from maps.spec import SEAT_COLOURS, MapSpec
from world import constants as c
from world.bodies import Item, build_bodies
from world.drive import drive_command
from world.errors import ActionError, WorldError
from world.grab import toggle_hand
from world.scoring import goal_boxes, is_delivered
from world.state import Floats, WorldState

# Sub-steps of the two halves; with sub-poses, cut where one is due: after sub-step 4, 8, 12 and 16.
_PLAIN_HALVES = ((10,), (10,))
_SAMPLED_HALVES = ((4, 4, 2), (2, 4, 4))
_ACTIONS_SHAPE = (2, 3)
_TICK_BYTES = 2 * 3 * 8

Actions = npt.NDArray[Any] | Sequence[Sequence[float]]

_Pose = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Snapshot:
    """One moment of a world: its map and every action so far. Small, picklable, exact on any machine."""

    map: MapSpec
    actions: bytes  # ticks x 2 x 3 float64

    @property
    def tick(self) -> int:
        return len(self.actions) // _TICK_BYTES


class World:
    """The simulated world of one map; `step` is the one way to advance time.

    The same map and actions give the same floats. `record_sub_poses=False` is for headless runs: it saves
    reading the poses inside each tick, and `sub_poses` then raises.
    """

    def __init__(self, map_spec: MapSpec, *, record_sub_poses: bool = True) -> None:
        self.map = map_spec
        self._record_sub_poses = record_sub_poses
        self._halves = _SAMPLED_HALVES if record_sub_poses else _PLAIN_HALVES
        self._goals = goal_boxes(map_spec)
        self._build()

    def _build(self) -> None:
        self._bodies = build_bodies(self.map)
        self._space = self._bodies.space._space
        self._control_angles = [pose.angle for pose in self.map.robots]
        self._log = array("d")
        self._failed = False
        self._moving: list[Item] = []  # items that may have moved in this tick
        self._item_poses = [_pose(item.handle) for item in self._bodies.items]
        self._robot_rows = [_pose_and_velocity(robot.handle) for robot in self._bodies.robots]
        self._held = [-1, -1]
        self._delivered: list[bool | None] = [None] * len(self._item_poses)  # None: to be looked up
        self._sub_poses = [self._sample() for _ in range(c.SUB_POSE_COUNT)]

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
        samples: list[list[_Pose]] = []
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
        rows = np.array(self._robot_rows)
        return WorldState(
            tick=self.tick,
            robot_poses=rows[:, :3].copy(),
            robot_velocities=rows[:, 3:].copy(),
            held=np.array(self._held, dtype=np.int64),
            item_poses=np.array(self._item_poses),
        )

    def delivered(self) -> npt.NDArray[np.bool_]:
        """(N,) which items are delivered now (see world.scoring)."""
        for index, flag in enumerate(self._delivered):
            if flag is None:
                spec = self.map.items[index]
                self._delivered[index] = is_delivered(spec, self._item_poses[index], self._goals)
        return np.array(self._delivered, dtype=np.bool_)

    def score(self) -> float:
        """The official global_score: delivered items / items, in [0, 1]."""
        return float(np.mean(self.delivered()))

    def sub_poses(self) -> Floats:
        """(5, 2 + N, 3) x, y, angle of robots and items, every 20 ms of the last tick; the last row is now."""
        if not self._record_sub_poses:
            raise WorldError("this world records no sub-poses; make it with World(map, record_sub_poses=True)")
        return np.array(self._sub_poses)

    def snapshot(self) -> Snapshot:
        """This moment, to come back to with `restore`, here or in another World of the same map."""
        return Snapshot(self.map, self._log.tobytes())

    def restore(self, snapshot: Snapshot) -> None:
        """Be at the snapshot's moment again, exact to the bit, by simulating its actions again.

        Costs about 50 microseconds per tick: of the whole episode, or of what is new when the snapshot lies
        ahead of this world on the same actions. An engine state cannot be copied exactly any other way.
        """
        if snapshot.map != self.map:
            raise WorldError(f"this snapshot is of map {snapshot.map.name!r}, this world of {self.map.name!r}")
        done = self._log.tobytes()
        if self._failed or not snapshot.actions.startswith(done):
            self._build()
            done = b""
        for actions in np.frombuffer(snapshot.actions[len(done) :]).reshape(-1, *_ACTIONS_SHAPE):
            self.step(actions)

    def _stop_held_items(self) -> None:
        self._moving = []
        self._note_moving()
        for item in self._moving:
            item.body.velocity = (0.0, 0.0)
            item.body.angular_velocity = 0.0

    def _note_moving(self) -> None:
        for robot in self._bodies.robots:
            if robot.item is not None and robot.item not in self._moving:
                self._moving.append(robot.item)

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

    def _advance(self, blocks: tuple[int, ...], samples: list[list[_Pose]]) -> None:
        space, engine_step, dt = self._space, lib.cpSpaceStep, c.SUB_STEP_SECONDS
        for block, sub_steps in enumerate(blocks):
            if block:
                samples.append(self._sample())
            for _ in range(sub_steps):
                engine_step(space, dt)

    def _sample(self) -> list[_Pose]:
        """Poses of robots and items now; what is not moving is taken from the last tick."""
        items = self._item_poses.copy()
        for item in self._moving:
            items[item.index] = _pose(item.handle)
        blue, red = self._bodies.robots
        return [_pose(blue.handle), _pose(red.handle), *items]

    def _finish(self, samples: list[list[_Pose]]) -> None:
        """Take over the poses of the finished tick, unless the engine has lost its numbers."""
        robots = [_pose_and_velocity(robot.handle) for robot in self._bodies.robots]
        moved = [(item.index, _pose(item.handle)) for item in self._moving]
        if not all(math.isfinite(sum(row)) for row in (*robots, *(pose for _, pose in moved))):
            self._failed = True
            raise WorldError(_lost_numbers(self.tick + 1, robots))
        self._robot_rows = robots
        for index, pose in moved:
            self._item_poses[index] = pose
            self._delivered[index] = None
        self._held = [-1 if robot.item is None else robot.item.index for robot in self._bodies.robots]
        if self._record_sub_poses:
            samples.append([robots[0][:3], robots[1][:3], *self._item_poses])
            self._sub_poses = samples


def _pose(handle: Any) -> _Pose:
    position = lib.cpBodyGetPosition(handle)
    return position.x, position.y, lib.cpBodyGetAngle(handle)


def _pose_and_velocity(handle: Any) -> tuple[float, float, float, float, float, float]:
    position, velocity = lib.cpBodyGetPosition(handle), lib.cpBodyGetVelocity(handle)
    angle, turn = lib.cpBodyGetAngle(handle), lib.cpBodyGetAngularVelocity(handle)
    return position.x, position.y, angle, velocity.x, velocity.y, turn


def _checked(actions: Actions) -> list[list[float]]:
    """The actions as two rows of three finite floats."""
    try:
        array = np.asarray(actions, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ActionError(f"actions are (2, 3) numbers: distance, heading, grasp of blue and red; {error}") from error
    if array.shape != _ACTIONS_SHAPE:
        raise ActionError(f"actions are (2, 3): distance, heading, grasp of blue and red; got shape {array.shape}")
    rows: list[list[float]] = array.tolist()
    for colour, row in zip(SEAT_COLOURS, rows, strict=True):
        if not all(map(math.isfinite, row)):
            raise ActionError(f"{colour}'s action {row} is not finite; distance, heading and grasp must be numbers")
    return rows


def _lost_numbers(tick: int, robots: list[tuple[float, float, float, float, float, float]]) -> str:
    places = ", ".join(f"{colour} at ({row[0]}, {row[1]})" for colour, row in zip(SEAT_COLOURS, robots, strict=True))
    return f"the physics lost its numbers in tick {tick} ({places}); the episode cannot go on, start a new one"
