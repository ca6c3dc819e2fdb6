"""How much noise a pose stands before what follows is no longer physically valid (paper, "Pose-noise augmentation").

One robot of a recorded state is moved and turned at random; from there the engine plays the recorded actions. The paper
does not say what it calls valid; here it is what recombination asks for, too: the state can be staged, both hands do as
recorded, and both robots end near where they were recorded.
"""

from collections.abc import Sequence

import numpy as np

from movingout.agents.bass.recombination import LENGTH, TOLERANCE
from movingout.agents.bass.restored_world import restage
from movingout.agents.data.dataset import Trajectory
from movingout.agents.errors import DataError
from movingout.world.errors import WorldError
from movingout.world.state import WorldState


def valid_after_noise(
    trajectories: Sequence[Trajectory], deviation: float, samples: int, seed: int = 0
) -> list[tuple[str, float]]:
    """Whether each of `samples` random moments stays valid for LENGTH ticks after noise on a random robot's pose.

    (episode, 1 or 0) per moment: those of one episode are alike, so that an error has to take them together.
    `deviation` is that of x, y [u] and of the angle [rad]. Raises DataError when all episodes are too short.
    """
    random = np.random.default_rng(seed)
    long_enough = [trajectory for trajectory in trajectories if trajectory.ticks >= LENGTH]
    if not long_enough:
        raise DataError(f"no episode has the {LENGTH} ticks over which noise is judged; record longer ones")
    valid: list[tuple[str, float]] = []
    for _ in range(samples):
        number = int(random.integers(len(long_enough)))
        trajectory = long_enough[number]
        tick = int(random.integers(trajectory.ticks - LENGTH + 1))
        robot_poses = trajectory.robot_poses[tick].copy()
        robot_poses[random.integers(2)] += random.normal(0.0, deviation, 3)
        start = WorldState(
            tick, robot_poses, trajectory.robot_velocities[tick], trajectory.held[tick], trajectory.item_poses[tick]
        )
        valid.append((str(number), float(_stays_valid(trajectory, tick, start))))
    return valid


def _stays_valid(trajectory: Trajectory, tick: int, start: WorldState) -> bool:
    try:
        world = restage(trajectory.map, start)
        for action in trajectory.actions[tick : tick + LENGTH]:
            world.step(action)
            now = tick + (world.tick - 1 if start.held.max() >= 0 else world.tick)  # grasping again takes a tick
            if not np.array_equal(world.state().held, trajectory.held[now]):
                return False
    except WorldError:
        return False
    ends, recorded = world.state().robot_poses[:, :2], trajectory.robot_poses[tick + LENGTH, :, :2]
    return bool((np.linalg.norm(ends - recorded, axis=1) <= TOLERANCE).all())
