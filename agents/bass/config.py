"""How the simulator and the value of BASS are trained, and how it chooses with them. Knows no torch."""

from dataclasses import dataclass
from typing import Literal

from movingout.agents.checkpoint.checkpoint import (
    Combine,
    DynamicsKind,
    DynamicsSpec,
    SelectionScore,
    SelectionSpec,
    ValueSpec,
)
from movingout.agents.errors import DataError
from movingout.agents.training.optimisation import AtLeastOne, Optimisation, described, documented

Order = Literal["joint", "fine-tuned", "separate"]


@dataclass(frozen=True, kw_only=True)
class BassConfig(Optimisation):
    """The simulator of BASS, its value, and how candidates are chosen with them."""

    dynamics: DynamicsKind = documented("vae", "vae (the paper's two autoencoders) or gru (its baseline)", "never")
    width: int = documented(192, "units per layer", "never")
    latent: int = documented(64, "latent dimensions", "never")
    residual: bool = documented(True, "predict the change of the state instead of the state", "never")
    rigid: bool = documented(True, "held items move rigidly with the holder instead of being predicted", "never")
    grasping: bool = documented(True, "the effect of a press is computed instead of predicted", "never")
    order: Order = documented(
        "joint", "joint, fine-tuned (second autoencoder starts from the first) or separate; see the paper", "never"
    )
    own: int = documented(8, "own candidates", "free")
    partner: int = documented(2, "predicted chunks of the partner", "free")
    combine: Combine = documented("product", "product (all combinations) or independent (pairs)", "free")
    score: SelectionScore = documented("value", "nfd, nfd+ac, or value: progress made plus progress expected", "free")
    depth: int = documented(8, "ticks simulated", "free")
    value_width: int = documented(256, "score value: units per layer of the value network", "never")
    value_members: int = documented(4, "score value: networks in the ensemble, each with its own batches", "never")
    value_updates: AtLeastOne = documented(800, "score value: gradient steps of the value network", "free")
    discount: float = documented(0.98, "score value: discount per tick", "never")

    def spec(self) -> DynamicsSpec:
        """The network's description. Raises DataError for an impossible combination."""
        names = ("width", "latent", "residual", "rigid", "grasping")
        return described(DynamicsSpec, {"kind": self.dynamics} | {name: getattr(self, name) for name in names})

    def selection(self) -> SelectionSpec:
        """How candidates are chosen. Raises DataError for numbers out of bounds."""
        names = ("own", "partner", "combine", "score", "depth")
        return described(SelectionSpec, {name: getattr(self, name) for name in names})

    def value_spec(self) -> ValueSpec:
        """The value network's description. Raises DataError for an impossible combination."""
        options = {"width": "value_width", "members": "value_members", "discount": "discount"}
        values = {name: getattr(self, option) for name, option in options.items()}
        return described(ValueSpec, values, options)

    def check(self) -> None:
        super().check()
        self.spec(), self.selection(), self.value_spec()
        if self.order != "joint" and self.dynamics != "vae":
            raise DataError(f"--order {self.order} is for autoencoders; --dynamics {self.dynamics} has none")
        if self.order == "fine-tuned" and self.residual:
            raise DataError(
                "--order fine-tuned needs --residual no: the first autoencoder predicts states, not changes"
            )
