"""Rows that are settings of this project, beside the paper's: nothing has to be trained or played for them."""

from collections.abc import Mapping

from movingout.agents.reinforcement.mappo_config import ON_COORDINATION, PAPER
from movingout.maps.spec import ARENA_HALF
from movingout.matches.paper.cells import DefinedCell
from movingout.matches.paper.entry import RowCells
from movingout.world import reward

WITHIN_99 = 2.576  # standard deviations to both sides, between which 99 % of a normal distribution lie

_OF_MAPPO = {
    "Gamma": "discount", "Learning rate": "rate", "Clip gradient value": "clip", "Clip epsilon": "clip_ratio",
    "Critic coefficient": "critic_weight", "Entropy coefficient": "entropy", "Lambda for GAE": "trace",
    "Max cycles per episode": "ticks", "Max frames": "frames", "Collected frames per batch": "frames_per_batch",
    "Environments per worker": "envs", "Minibatch iterations": "passes", "Minibatch size": "batch",
    "Units per layer": "width",
}  # fmt: skip
"""The paper's name of a number, and the option of `movingout train mappo`."""


def _defined(value: float) -> RowCells:
    return lambda column: DefinedCell(value)


MAPPO_ROWS: Mapping[tuple[str, str], RowCells] = {
    **{("", name): _defined(PAPER[option]) for name, option in _OF_MAPPO.items()},
    **{
        ("Maps 1 to 4", name): _defined(ON_COORDINATION[option])
        for name, option in _OF_MAPPO.items()
        if option in ON_COORDINATION
    },
}
REWARD_ROWS: Mapping[tuple[str, str], RowCells] = {
    ("Distance", "Closer to the nearest item, to one that needs help, or with an item to a goal, per unit"): _defined(
        reward.GAMMA
    ),
    ("Holding", "Grasps an item"): _defined(reward.HOLD),
    ("Holding", "Grasps while another holds a middle or large item"): _defined(reward.HOLD_UNWANTED),
    ("Holding", "Grasps an item that lies in a goal"): _defined(reward.HOLD_UNWANTED),
    ("Letting go", "Inside a goal"): _defined(reward.RELEASE_INSIDE),
    ("Letting go", "Outside"): _defined(reward.RELEASE_OUTSIDE),
    ("Letting go", "While another needs help, in addition"): _defined(reward.RELEASE_TO_HELP),
    ("Time", "Each tick"): _defined(reward.STEP_COST),
}


def pose_shift(deviation: float) -> DefinedCell:
    """How far 99 % of coordinates are shifted at most, as a share of the largest, 1.2 (paper: 0.005 is 0.4 %)."""
    return DefinedCell(float(f"{WITHIN_99 * deviation / ARENA_HALF:.2g}"))
