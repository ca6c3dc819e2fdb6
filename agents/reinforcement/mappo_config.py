"""How MAPPO and CoMeDi are learned. Knows no torch.

The preset `paper` has the paper's numbers ("MAPPO Training Setting"). Five of its table do nothing in MAPPO, neither
here nor in the library that the paper used: soft updates of target networks, their tau, the frequency of hard ones, and
exploration epsilon at the beginning and at the end.
What the paper has and nobody needs to change is no option: ADAM_EPSILON, CRITIC_LOSS.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal, Self

from pydantic import Field, FiniteFloat

from movingout.agents.checkpoint.policy_spec import Grasp, PolicySpec
from movingout.agents.errors import DataError
from movingout.agents.training.optimisation import (
    AtLeastOne,
    NotNegativeFloat,
    Optimisation,
    described,
    documented,
)
from movingout.world.constants import LIMIT_TICKS

Reward = Literal["paper-dense", "paper-agent-distance", "paper-sparse", "official-dense"]
ArenaLayout = Literal["official-v1", "map-v1", "aware-v1"]
"""Those with headings of the arena, as the environment takes them."""
ON_COORDINATION: Mapping[str, Any] = {"ticks": 3000, "entropy": 0.00065, "discount": 0.92}
"""What the paper changes on maps 1 to 4, where the ways are longer."""


ADAM_EPSILON = 1e-6
CRITIC_LOSS = "l2"


@dataclass(frozen=True, kw_only=True)
class MappoConfig(Optimisation):
    """How MAPPO is learned."""

    UNUSED = frozenset(
        {"updates", "epochs", "warmup", "decay", "ema", "held_out", "precision", "compile", "window_share"}
    )

    frames: AtLeastOne = documented(100_000, "ticks to play, rounded up to whole rounds; both seats learn", "free")
    envs: AtLeastOne = documented(10, "episodes that are played at the same time")
    frames_per_batch: AtLeastOne = documented(6000, "ticks that are played between rounds of learning")
    passes: AtLeastOne = documented(10, "passes over what was played")
    batch: AtLeastOne = documented(400, "ticks per gradient step")
    rate: Annotated[FiniteFloat, Field(gt=0.0)] = documented(3e-4, "learning rate of Adam")
    clip: NotNegativeFloat = documented(5.0, "largest norm of the gradient of each network; 0: not clipped")
    evaluate_every: AtLeastOne = documented(5, "rounds between resume files", "free")
    ticks: AtLeastOne = documented(LIMIT_TICKS, "limit of an episode that is learned from")
    reward: Reward = documented(
        "paper-dense", "what is rewarded: paper-dense, paper-agent-distance, paper-sparse or official-dense"
    )
    discount: Annotated[FiniteFloat, Field(ge=0.0, le=1.0)] = documented(0.99, "discount per tick")
    trace: Annotated[FiniteFloat, Field(ge=0.0, le=1.0)] = documented(0.9, "lambda of the generalised advantages")
    clip_ratio: Annotated[FiniteFloat, Field(gt=0.0, lt=1.0)] = documented(
        0.2, "how far a probability may change in a round"
    )
    critic_weight: NotNegativeFloat = documented(1.0, "weight of the critic's squared error")
    entropy: NotNegativeFloat = documented(0.0, "weight of the entropy of the actions")
    normalise: bool = documented(True, "bring the advantages of a gradient step to mean 0 and deviation 1")
    layout: ArenaLayout = documented("official-v1", "observation layout: official-v1, map-v1 or aware-v1", "never")
    grasp: Grasp = documented("hold", "the fourth action: hold (desired level) or toggle (official)", "never")
    width: int = documented(256, "units per layer of actor and critic", "never")
    depth: int = documented(2, "layers of actor and critic", "never")

    @property
    def room_ticks(self) -> int:
        """Ticks that each environment plays in a round."""
        return -(-self.frames_per_batch // self.envs)

    @property
    def rounds(self) -> int:
        """Of playing and learning."""
        return -(-self.frames // (self.room_ticks * self.envs))

    @property
    def whole_frames(self) -> int:
        """Ticks that are played: whole rounds."""
        return self.rounds * self.room_ticks * self.envs

    def spec(self, kind: str) -> PolicySpec:
        """The network's description: one action for one observation. Raises DataError."""
        shape = {"layout": self.layout, "grasp": self.grasp, "width": self.width, "depth": self.depth}
        return described(PolicySpec, {"kind": kind, "obs_horizon": 1, "horizon": 1, "execute": 1, **shape})

    def check(self) -> None:
        """Raises DataError, also for values that do not go together."""
        super().check()
        self.spec("mappo")
        if self.frames_per_batch < self.envs:
            raise DataError(f"--frames-per-batch {self.frames_per_batch}: {self.envs} environments play at least one")
        if self.frames < self.frames_per_batch:
            raise DataError(
                f"--frames {self.frames:,} is less than a round, after which something is learned; give at least "
                f"{self.frames_per_batch:,}, or shorter rounds with --frames-per-batch"
            )


@dataclass(frozen=True, kw_only=True)
class ComediConfig(MappoConfig):
    """How CoMeDi is learned: --frames for each member of the population, and for the answer to all of them."""

    members: Annotated[int, Field(ge=1, le=16)] = documented(3, "conventions of the population")
    cross: NotNegativeFloat = documented(0.3, "weight of the reward with the most compatible earlier convention")
    mixed: NotNegativeFloat = documented(0.3, "weight of the reward of self-play that goes on from such play")

    def of_member(self, number: int) -> Self:
        """The same with a seed of its own."""
        return replace(self, seed=(self.seed + 1_000_003 * number) % 2**32)

    def check(self) -> None:
        """Raises DataError, also for values that do not go together."""
        super().check()
        if self.members > 1 and self.envs < 3 * (self.members - 1):
            raise DataError(
                f"--envs {self.envs}: {self.members} members need {3 * (self.members - 1)} environments or more, "
                "for self-play, cross-play and mixed-play with each earlier one"
            )


PAPER: Mapping[str, Any] = {
    "frames": 30_000_000, "envs": 10, "frames_per_batch": 6000, "passes": 45, "batch": 400, "rate": 5e-5, "clip": 5.0,
    "ticks": 1000, "discount": 0.99, "trace": 0.9, "clip_ratio": 0.2, "critic_weight": 1.0, "entropy": 0.0,
    "normalise": False, "layout": "official-v1", "grasp": "toggle", "width": 256, "depth": 2,
}  # fmt: skip
