"""How a best response is learned. Knows no torch."""

from dataclasses import dataclass
from typing import Annotated

from pydantic import Field, FiniteFloat

from movingout.agents.training.optimisation import AtLeastOne, NotNegativeFloat, Optimisation, documented


@dataclass(frozen=True, kw_only=True)
class ResponseConfig(Optimisation):
    """How a best response is learned."""

    UNUSED = frozenset({"epochs", "warmup", "ema", "held_out", "precision", "compile", "window_share"})

    updates: AtLeastOne = documented(300, "rounds of playing and learning", "free")
    batch: AtLeastOne = documented(512, "decisions per gradient step")
    rate: Annotated[FiniteFloat, Field(gt=0.0)] = documented(3e-4, "learning rate of AdamW")
    evaluate_every: AtLeastOne = documented(5, "rounds between resume files", "free")
    rooms: AtLeastOne = documented(16, "episodes that are played at the same time", "free")
    decisions: AtLeastOne = documented(128, "decisions in each room between rounds of learning", "free")
    passes: AtLeastOne = documented(3, "passes over what was played, in batches of --batch", "free")
    leash: NotNegativeFloat = documented(0.02, "weight of the divergence from the imitated policy")
    discount: float = documented(0.99, "discount per decision")
    trace: float = documented(0.95, "lambda of the generalised advantages")
    clip_ratio: float = documented(0.2, "how far a probability may change in a round")
