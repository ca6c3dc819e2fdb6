"""How a policy is trained: the configuration that MLP, GRU and diffusion policies share. Knows no torch."""

import re
from dataclasses import dataclass, fields, replace
from typing import Annotated, Any, Self

from pydantic import AfterValidator

from movingout.agents.bass.recombination import Matching
from movingout.agents.checkpoint.policy_spec import Denoiser, Grasp, LayoutName, PolicySpec, Process
from movingout.agents.errors import DataError
from movingout.agents.training.optimisation import (
    AtLeastOne,
    NotNegativeFloat,
    Optimisation,
    Share,
    described,
    documented,
)
from movingout.world.observation import LAYOUTS


def _lags(text: str) -> str:
    if not re.fullmatch(r"(\d{1,3}(,\d{1,3})*)?", text):
        raise ValueError("numbers of ticks joined by commas are needed, such as 3,10,30")
    return text


LagsText = Annotated[str, AfterValidator(_lags)]


def shape_of(network: PolicySpec) -> dict[str, Any]:
    """The fields of a configuration that shape the network, as that of a card has them."""
    lags = ",".join(map(str, network.lags))
    return {**network.model_dump(exclude={"kind", "lags", "latent"}), "lags": lags}


@dataclass(frozen=True, kw_only=True)
class PolicyConfig(Optimisation):
    """A policy and its training; the fields that shape the network are those of its card."""

    layout: LayoutName = documented(
        "aware-v1",
        "observation layout: official-v1, map-v1 (adds walls and goals), aware-v1 (adds ways), "
        "relative-v1 (own frame), image-v1 (a picture)",
        "never",
    )
    lags: LagsText = documented("", "relative-v1 only: how many ticks back it remembers, such as 3,10,30", "never")
    mirror: Share = documented(0.5, "augmentation: share of windows that are mirrored, where the layout allows it")
    forget: Share = documented(0.2, "augmentation: share of windows whose memory says that nothing has changed")
    obs_horizon: int = documented(
        1, "observations that the policy sees: the present one and obs_horizon - 1 earlier ones", "never"
    )
    horizon: int = documented(8, "actions predicted", "never")
    execute: int = documented(2, "actions played between decisions", "free")
    grasp: Grasp = documented(
        "hold", "what is predicted for the hand: hold (desired level) or toggle (official)", "never"
    )
    width: int = documented(512, "units per layer; channels of the first level of a U-Net", "never")
    depth: int = documented(3, "layers, or residual blocks", "never")
    dropout: float = documented(0.0, "dropout in the network")
    denoiser: Denoiser = documented(
        "resmlp",
        "resmlp, items (a resmlp that encodes items with shared weights), cnn (for pictures) or unet",
        "never",
    )
    process: Process = documented("flow", "flow, ddim or ddpm", "never")
    train_steps: int = documented(36, "diffusion steps in training (ddim, ddpm)", "never")
    sample_steps: int = documented(4, "sampling steps per decision", "free")
    restless: float = documented(1.0, "factor on the sampling noise after a standstill of 2 s", "free")
    pose_noise: NotNegativeFloat = documented(
        0.0, "augmentation: standard deviation of noise on the partner's pose; paper 0.002"
    )
    recombine: NotNegativeFloat = documented(
        0.0, "augmentation: recombined stretches to add, as a share of the recorded windows"
    )
    matching: Matching = documented(
        "both-ends",
        "recombined stretches share start and end (both-ends, paper), start or end (either-end, its single-agent "
        "ablation), or the start (one-end)",
    )
    confirm: bool = documented(
        True, "recombined stretches are played by the engine, and only possible ones are kept (no: put together unseen)"
    )
    event_weight: AtLeastOne = documented(
        1, "how many times as often windows are drawn in which the hand is about to change", "free"
    )
    grasp_weight: NotNegativeFloat = documented(1.0, "weight of the grasp in the loss")

    def spec(self, kind: str) -> PolicySpec:
        """The network's description. Raises DataError for an impossible combination."""
        names = {entry.name for entry in fields(self)} & set(PolicySpec.model_fields) - {"lags"}
        lags = tuple(map(int, self.lags.split(","))) if self.lags else ()
        return described(PolicySpec, {"kind": kind, "lags": lags} | {name: getattr(self, name) for name in names})

    def shaped(self, network: PolicySpec) -> Self:
        """The same training of another network. Raises DataError where the two do not go together."""
        changed = replace(self, **shape_of(network))
        changed.check()
        return changed

    def check(self) -> None:
        """Raises DataError, also for values that do not go together."""
        super().check()
        if self.event_weight > 1 and self.grasp != "hold":
            raise DataError("--event-weight needs hold levels; train with --grasp hold")
        if self.pose_noise and LAYOUTS[self.layout].picture:
            raise DataError(f"--pose-noise is for layouts of numbers; leave it out with {self.layout}")
        if self.pose_noise and LAYOUTS[self.layout].partner_pose is None:
            raise DataError(f"--pose-noise is for layouts with places of the arena; leave it out with {self.layout}")


@dataclass(frozen=True, kw_only=True)
class RegressionConfig(PolicyConfig):
    """A policy that predicts at once: it has no denoiser, and so no dropout and no sampling."""

    UNUSED = frozenset({"dropout", "denoiser", "process", "train_steps", "sample_steps", "restless"})

    layout: LayoutName = documented(
        "aware-v1",
        "observation layout: official-v1, map-v1 (adds walls and goals), aware-v1 (adds ways) or relative-v1 (own "
        "frame); image-v1 (a picture) is for `train dp` alone",
        "never",
    )

    def check(self) -> None:
        """Raises DataError, also for values that do not go together."""
        super().check()
        if LAYOUTS[self.layout].picture:
            raise DataError(f"--layout {self.layout} is for `train dp`: no other policy reads pictures")
