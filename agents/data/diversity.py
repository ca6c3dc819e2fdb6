"""How diverse a set of trajectories is, by the paper's four measures (`recordings.diversity`)."""

from collections.abc import Sequence

from movingout.agents.data.dataset import Trajectory
from movingout.recordings.diversity.measures import DEFAULT, Diversity, DiversityOptions, PathSet
from movingout.world.state import Floats


def diversity(trajectories: Sequence[Trajectory], options: DiversityOptions = DEFAULT) -> Diversity:
    """The four measures. Three of them need two episodes and are 0 with fewer."""
    return PathSet([path_of(trajectory) for trajectory in trajectories], options).diversity()


def path_of(trajectory: Trajectory) -> Floats:
    """(T + 1, 4): x, y of blue and red."""
    path: Floats = trajectory.robot_poses[..., :2].reshape(-1, 4)
    return path
