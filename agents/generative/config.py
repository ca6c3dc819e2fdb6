"""How a generative model of partners is trained. Knows no torch."""

from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field

from movingout.agents.errors import DataError
from movingout.agents.policies.config import PolicyConfig
from movingout.agents.training.optimisation import NotNegativeFloat, documented


@dataclass(frozen=True, kw_only=True)
class LatentConfig(PolicyConfig):
    """A diffusion policy that is told who plays by a latent vector, and an encoder of that vector.

    It learns from episodes as they are.
    """

    UNUSED = frozenset({"recombine", "matching", "confirm", "event_weight", "window_share"})

    grasp: Literal["hold"] = documented("hold", "what is predicted for the hand: hold (desired level)", "never")
    latent: Annotated[int, Field(ge=1, le=64)] = documented(8, "numbers that say who plays", "never")
    beta: NotNegativeFloat = documented(
        0.001, "weight of the divergence [nat] of an episode's latent from the prior in the loss"
    )
    episode_windows: Annotated[int, Field(ge=2, le=1024)] = documented(
        32, "windows of an episode in a batch, an even number: each half says who plays in the other one"
    )

    def check(self) -> None:
        """Raises DataError, also for values that do not go together."""
        super().check()
        if changed := [name for name in sorted(self.UNUSED) if getattr(self, name) != getattr(LatentConfig, name)]:
            raise DataError(f"a latent model learns from episodes as they are: leave out {changed[0]}")
        if self.episode_windows % 2 or self.episode_windows > self.batch:
            raise DataError(
                f"--episode-windows is an even number of at most --batch {self.batch}, not {self.episode_windows}"
            )

    @property
    def batch_episodes(self) -> int:
        """Episodes in a batch."""
        return self.batch // self.episode_windows
