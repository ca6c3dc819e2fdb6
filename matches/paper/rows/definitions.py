"""Rows that are settings of this project, beside the paper's: nothing has to be trained or played for them."""

from collections.abc import Iterator, Mapping

from movingout.agents.kinds.registry import KINDS
from movingout.agents.reinforcement.mappo_config import ADAM_EPSILON, CRITIC_LOSS, ON_COORDINATION, PAPER
from movingout.maps.flood_fill import PAPER_CELLS
from movingout.maps.spec import ARENA_HALF
from movingout.matches.paper.cells import DefinedCell
from movingout.matches.paper.entry import RowCells
from movingout.matches.paper.methods import POSE_NOISE
from movingout.matches.paper.published import published_tables
from movingout.world import reward

LINEAR_LAYERS = 3  # of each encoder and decoder of BASS (`agents.bass.dynamics`, which needs torch)
WITHIN_99 = 2.576  # standard deviations to both sides, between which 99 % of a normal distribution lie

NO_TARGET = "not used: MAPPO has no target networks"
NO_EPSILON = "not used: MAPPO draws actions from its distribution"

_OF_MAPPO = {
    "Gamma": "discount", "Learning Rate": "rate", "Clip Gradient Value": "clip", "Clip Epsilon": "clip_ratio",
    "Critic Coefficient": "critic_weight", "Entropy Coefficient": "entropy", "Lambda for GAE": "trace",
    "Max Cycles Per Episode": "ticks", "Max Frames": "frames",
    "On-Policy Collected Frames Per Batch": "frames_per_batch", "On-Policy Environments Per Worker": "envs",
    "On-Policy Minibatch Iterations": "passes", "On-Policy Minibatch Size": "batch",
}  # fmt: skip
"""The paper's name of a number, and the option of `movingout train mappo`."""
_FIXED: Mapping[str, float | str] = {
    "Share Policy Parameters": "True", "Share Policy Critic": "True", "Adam Epsilon": ADAM_EPSILON,
    "Clip Gradient Norm": str(PAPER["clip"] > 0.0), "Critic Loss Type": CRITIC_LOSS, "Model Type": "MLP",
    "Linear Layer Sizes": str([PAPER["width"]] * PAPER["depth"]), "Activation Function": "torch.nn.Tanh",
    "Soft Target Update": NO_TARGET, "Polyak Tau": NO_TARGET, "Hard Target Update Frequency": NO_TARGET,
    "Initial Exploration Epsilon": NO_EPSILON, "Final Exploration Epsilon": NO_EPSILON,
}  # fmt: skip
"""What is no option: both seats share an actor and a critic (`agents.reinforcement.mappo`)."""


def _defined(value: float | str) -> RowCells:
    return lambda column: DefinedCell(value)


MAPPO_ROWS: Mapping[tuple[str, str], RowCells] = {
    **{("", name): _defined(PAPER[option]) for name, option in _OF_MAPPO.items()},
    **{("", name): _defined(value) for name, value in _FIXED.items()},
    **{
        ("Maps 1 to 4", name): _defined(ON_COORDINATION[option])
        for name, option in _OF_MAPPO.items()
        if option in ON_COORDINATION
    },
}
_DISTANCE, _HOLDS, _UNHOLDS, _TIME = (
    "A. Distance-based Rewards", "B. Event-based Rewards: Agent Holds an Item",
    "C. Event-based Rewards: Agent Unholds an Item", "D. Time-based Reward (Step Cost)",
)  # fmt: skip
REWARD_ROWS: Mapping[tuple[str, str], RowCells] = {
    (_DISTANCE, "Not holding: closer to the nearest available item"): _defined(reward.GAMMA),
    (_DISTANCE, "Not holding: closer to a middle or large item held by another agent"): _defined(reward.GAMMA),
    (_DISTANCE, "Holding: closer to the nearest goal region"): _defined(reward.GAMMA),
    (_HOLDS, "Default reward for picking up"): _defined(reward.HOLD),
    (_HOLDS, "Exception: another agent holds another middle or large item"): _defined(reward.HOLD_UNWANTED),
    (_HOLDS, "Exception: the item was already in a goal region"): _defined(reward.HOLD_UNWANTED),
    (_UNHOLDS, "Released inside a goal region"): _defined(reward.RELEASE_INSIDE),
    (_UNHOLDS, "Released not inside a goal region"): _defined(reward.RELEASE_OUTSIDE),
    (_UNHOLDS, "Exception: another agent needs help (in addition)"): _defined(reward.RELEASE_TO_HELP),
    (_TIME, "Each timestep"): _defined(reward.STEP_COST),
}


def _of_policy(name: str) -> Iterator[tuple[tuple[str, str], RowCells]]:
    """What the preset `paper` has, by the paper's names."""
    paper = KINDS[name].presets["paper"]
    network = {"Architecture": "U-Net" if paper.denoiser == "unet" else paper.denoiser} if name == "dp" else {}
    settings: dict[str, float | str] = {
        **network, "Observation horizon": paper.obs_horizon, "States": paper.obs_horizon,
        "Prediction horizon": paper.horizon, "Executable horizon": paper.execute,
        "Optimizer": "AdamW" if paper.decay else "Adam", "Epochs": paper.epochs, "Batch size": paper.batch,
        "Learning rate": paper.rate, "Diffusion steps": paper.train_steps, "Fully connected layers": paper.depth,
        "Hidden units": paper.width, "Activation": "Tanh",
    }  # fmt: skip
    group = {"dp": "Diffusion Policy", "mlp": "MLP", "gru": "GRU"}[name]
    return (((group, setting), _defined(value)) for setting, value in settings.items())


_BASS = KINDS["bass"].presets["paper"]
_POLICIES = dict(row for name in ("dp", "mlp", "gru") for row in _of_policy(name)) | {
    ("BASS", "Linear layers of encoder and decoder"): _defined(LINEAR_LAYERS),
    ("BASS", "Units per layer"): _defined(_BASS.width),
    ("BASS", "Latent dimensions"): _defined(_BASS.latent),
    ("BASS", "Candidates"): _defined(_BASS.own),
    ("BASS", "Standard deviation of the pose noise"): _defined(POSE_NOISE),
    ("BASS", "Cells of the grid, to each side"): _defined(PAPER_CELLS),
}
_NAMED = {(row.group, row.name) for row in published_tables()["text:policy_parameters"].rows}
POLICY_ROWS: Mapping[tuple[str, str], RowCells] = {name: row for name, row in _POLICIES.items() if name in _NAMED}


def pose_shift(deviation: float) -> DefinedCell:
    """How far 99 % of coordinates are shifted at most, as a share of the largest, 1.2 (paper: 0.005 is 0.4 %)."""
    return DefinedCell(float(f"{WITHIN_99 * deviation / ARENA_HALF:.2g}"))
