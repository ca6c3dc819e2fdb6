"""How the simulator and the value of BASS are trained, and how it chooses with them. Knows no torch."""

from dataclasses import dataclass
from typing import Literal

from movingout.agents.checkpoint.card import (
    Combine,
    DynamicsSpec,
    ProgressSpec,
    SelectionScore,
    SelectionSpec,
    ValueSpec,
)
from movingout.agents.checkpoint.policy_spec import LayoutName
from movingout.agents.errors import DataError
from movingout.agents.training.optimisation import AtLeastOne, NotNegativeFloat, Optimisation, described, documented
from movingout.world.observation import LAYOUTS

Order = Literal["joint", "fine-tuned", "separate"]
Simulated = Literal["vae", "gru", "qvae", "engine"]  # the learned ones are `DynamicsKind`


@dataclass(frozen=True, kw_only=True)
class BassConfig(Optimisation):
    """The simulator of BASS, its value, and how candidates are chosen with them."""

    UNUSED = frozenset({"window_share"})

    decay: NotNegativeFloat = documented(
        1e-4, "weight decay of the simulator and of the embedding of score tcl; the value network has 0.01"
    )
    dynamics: Simulated = documented(
        "vae",
        "vae (the paper's two autoencoders), gru or qvae (its baselines), or engine: nothing is learned, the "
        "world's own engine simulates from what is seen",
        "never",
    )
    width: int = documented(192, "units per layer", "never")
    latent: int = documented(64, "latent dimensions", "never")
    residual: bool = documented(True, "predict the change of the state instead of the state", "never")
    rigid: bool = documented(
        True, "held items move rigidly with the holder instead of being predicted", "never", before=False
    )
    grasping: bool = documented(True, "the effect of a press is computed instead of predicted", "never", before=False)
    order: Order = documented(
        "joint",
        "joint, fine-tuned (second autoencoder starts from the first) or separate; see the paper",
        "never",
        before="joint",
    )
    own: int = documented(8, "own candidates", "free")
    partner: int = documented(2, "predicted chunks of the partner", "free")
    combine: Combine = documented("product", "product (all combinations) or independent (pairs)", "free")
    score: SelectionScore = documented(
        "value",
        "nfd, nfd+ac, value: progress made plus progress expected, or tcl: progress learned without rewards",
        "free",
    )
    depth: int = documented(8, "ticks simulated", "free")
    value_width: int = documented(256, "score value: units per layer of the value network", "never")
    value_members: int = documented(4, "score value: networks in the ensemble, each with its own batches", "never")
    value_updates: AtLeastOne = documented(800, "score value: gradient steps of the value network", "free")
    value_layout: LayoutName = documented("aware-v1", "score value: the layout that the value network sees", "never")
    progress_width: int = documented(128, "score tcl: units per layer of the embedding", "never")
    progress_latent: int = documented(32, "score tcl: dimensions of the embedding", "never")
    progress_updates: AtLeastOne = documented(800, "score tcl: gradient steps of the embedding", "free")
    discount: float = documented(0.98, "score value: discount per tick", "never")
    caution: NotNegativeFloat = documented(
        0.0,
        "score value: the policy's own sample is played unless another is better by so many standard deviations of the "
        "ensemble; 0: never asks",
    )
    sub_steps: int = documented(
        20, "--dynamics engine: its steps per tick, 20 as in the world, or 10 for half the time", "free"
    )

    def spec(self) -> DynamicsSpec:
        """The network's description. Raises DataError for an impossible combination."""
        names = ("width", "latent", "residual", "rigid", "grasping")
        return described(DynamicsSpec, {"kind": self.dynamics} | {name: getattr(self, name) for name in names})

    def selection(self) -> SelectionSpec:
        """How candidates are chosen. Raises DataError for numbers out of bounds."""
        names = ("own", "partner", "combine", "score", "depth", "caution", "sub_steps")
        simulator = "engine" if self.dynamics == "engine" else "learned"
        return described(SelectionSpec, {name: getattr(self, name) for name in names} | {"simulator": simulator})

    def value_spec(self) -> ValueSpec:
        """The value network's description. Raises DataError for an impossible combination."""
        options = {
            "width": "value_width",
            "members": "value_members",
            "discount": "discount",
            "layout": "value_layout",
        }
        values = {name: getattr(self, option) for name, option in options.items()}
        return described(ValueSpec, {**values, "each": self.caution > 0.0}, options)

    def progress_spec(self) -> ProgressSpec:
        """The embedding's description. Raises DataError for an impossible combination."""
        options = {"width": "progress_width", "latent": "progress_latent"}
        return described(ProgressSpec, {name: getattr(self, option) for name, option in options.items()}, options)

    def check(self) -> None:
        """Raises DataError, also for values that do not go together."""
        super().check()
        self.selection(), self.value_spec(), self.progress_spec()
        if self.dynamics != "engine":
            self.spec()
        if not LAYOUTS[self.value_layout].items:
            known = " and ".join(layout.name for layout in LAYOUTS.values() if layout.items)
            raise DataError(f"--value-layout is {known}, not {self.value_layout}")
        if self.caution and self.score != "value":
            raise DataError(f"--caution is for --score value, not for --score {self.score}")
        if self.order != "joint" and self.dynamics != "vae":
            raise DataError(f"--order {self.order} is for autoencoders; --dynamics {self.dynamics} has none")
        if self.order == "fine-tuned" and self.residual:
            raise DataError(
                "--order fine-tuned needs --residual no: the first autoencoder predicts states, not changes"
            )
