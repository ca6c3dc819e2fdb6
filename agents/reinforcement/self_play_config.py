"""How a policy over options learns by playing with itself. Knows no torch."""

from dataclasses import dataclass
from typing import Annotated

from pydantic import Field, FiniteFloat

from movingout.agents.errors import DataError
from movingout.agents.training.optimisation import AtLeastOne, NotNegativeFloat, Optimisation, documented
from movingout.world.constants import LIMIT_TICKS


@dataclass(frozen=True, kw_only=True)
class SelfPlayConfig(Optimisation):
    """Both seats are played by one network; a round of episodes is played, then learned from."""

    UNUSED = frozenset(
        {
            "updates", "epochs", "warmup", "decay", "ema", "held_out", "precision", "compile", "window_share",
            "evaluate_every",
        }
    )  # fmt: skip

    episodes: AtLeastOne = documented(360, "episodes to play, rounded up to whole rounds", "free")
    round_episodes: AtLeastOne = documented(12, "episodes that are played between rounds of learning", "never")
    young: AtLeastOne = documented(120, "episodes after which a copy is kept, which plays as `age=young`", "never")
    passes: AtLeastOne = documented(4, "passes over what was played")
    batch: AtLeastOne = documented(256, "decisions per gradient step")
    rate: Annotated[FiniteFloat, Field(gt=0.0)] = documented(1e-3, "learning rate of Adam")
    clip: NotNegativeFloat = documented(0.5, "largest norm of the gradient; 0: not clipped")
    ticks: AtLeastOne = documented(LIMIT_TICKS, "limit of an episode that is learned from")
    discount: Annotated[FiniteFloat, Field(ge=0.0, lt=1.0)] = documented(0.99, "discount per tick")
    trace: Annotated[FiniteFloat, Field(ge=0.0, le=1.0)] = documented(
        0.95, "lambda of the generalised advantages, per decision"
    )
    clip_ratio: Annotated[FiniteFloat, Field(gt=0.0, lt=1.0)] = documented(
        0.2, "how far a probability may change in a round"
    )
    critic_weight: NotNegativeFloat = documented(0.5, "weight of the critic's error")
    entropy: NotNegativeFloat = documented(0.01, "weight of the entropy of the choice")
    cost: NotNegativeFloat = documented(0.0002, "what a tick costs, in progress")
    own: Annotated[FiniteFloat, Field(ge=0.0, le=1.0)] = documented(
        0.0, "share of the reward that is paid for what the seat itself holds; the rest is for all progress"
    )
    width: Annotated[int, Field(ge=4, le=512)] = documented(64, "units per layer", "never")

    @property
    def rounds(self) -> int:
        """Of playing and learning."""
        return -(-self.episodes // self.round_episodes)

    def check(self) -> None:
        """Raises DataError, also for values that do not go together."""
        super().check()
        played = self.rounds * self.round_episodes
        if self.young > played:
            raise DataError(f"--young {self.young}: only {played} episodes are played; give at most as many")
