"""What a training run is told: one frozen dataclass per kind, every field documented, made into the command line.

Words and numbers that cannot be are refused here, before anything is read or trained.
"""

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Annotated, Any, Literal, TypeVar

from pydantic import BaseModel, Field, FiniteFloat, TypeAdapter, ValidationError

from movingout.agents.bass.recombination import Matching
from movingout.agents.checkpoint.checkpoint import (
    Combine,
    DynamicsKind,
    DynamicsSpec,
    SelectionScore,
    SelectionSpec,
    ValueSpec,
)
from movingout.agents.checkpoint.policy_spec import Denoiser, Grasp, Layout, PolicyKind, PolicySpec, Process
from movingout.agents.errors import DataError

PRESETS = ("fast", "paper")
Order = Literal["joint", "fine-tuned", "separate"]
Precision = Literal["auto", "bf16", "fp32"]
ModelT = TypeVar("ModelT", bound=BaseModel)

SAME_NAMES: Mapping[str, str] = MappingProxyType({})
AtLeastOne = Annotated[int, Field(ge=1)]
NotNegative = Annotated[int, Field(ge=0)]
NotNegativeFloat = Annotated[FiniteFloat, Field(ge=0.0)]
Share = Annotated[FiniteFloat, Field(ge=0.0, lt=1.0)]


Change = Literal["free", "asked", "never"]
"""Whether a run that is gone on with may have another value: of course, on purpose alone, or it is another agent."""


def documented(default: Any, text: str, change: Change = "asked") -> Any:
    """A dataclass field with its help text."""
    return field(default=default, metadata={"help": text, "change": change})


@dataclass(frozen=True, kw_only=True)
class Optimisation:
    """How weights are fitted; the same for every network."""

    updates: AtLeastOne = documented(6000, "gradient steps; ignored when epochs is set", "free")
    epochs: NotNegative = documented(
        0, "passes over the training windows instead of a number of updates; 0: use updates", "free"
    )
    batch: AtLeastOne = documented(1024, "windows per update")
    rate: Annotated[FiniteFloat, Field(gt=0.0)] = documented(
        1e-3, "peak learning rate of AdamW, reached after the warm-up, then a cosine to 0"
    )
    warmup: NotNegative = documented(200, "updates until the peak learning rate")
    decay: NotNegativeFloat = documented(1e-4, "weight decay")
    clip: NotNegativeFloat = documented(1.0, "largest norm of the gradient; 0: not clipped")
    ema: Share = documented(0.999, "share that the moving average keeps per update; the average is what plays")
    held_out: Share = documented(0.1, "share of the participants kept for validation")
    seed: Annotated[int, Field(ge=0, lt=2**32)] = documented(0, "seed of initial weights, batches and noise")
    threads: Annotated[int, Field(ge=1, le=1024)] = documented(1, "CPU threads", "free")
    precision: Precision = documented(
        "auto",
        "bf16 (mixed precision), fp32, or auto: bf16 where it is faster: GPUs and processors with AVX512-BF16 or AMX",
        "free",
    )
    evaluate_every: AtLeastOne = documented(500, "updates between validations and resume files", "free")
    window_share: Annotated[FiniteFloat, Field(gt=0.0, le=1.0)] = documented(
        1.0, "share of the rows that are used, to try things out quickly"
    )

    def check(self) -> None:
        """Raises DataError, in a sentence, for a field out of bounds."""
        try:
            TypeAdapter(type(self)).validate_python(dataclasses.asdict(self))
        except ValidationError as error:
            raise DataError(_sentence(error)) from error


@dataclass(frozen=True, kw_only=True)
class PolicyConfig(Optimisation):
    """A policy and how it is trained; the fields of the network are those of its card."""

    layout: Layout = documented(
        "aware-v1", "observation layout: official-v1, map-v1 (walls and goals), aware-v1 (ways)", "never"
    )
    obs_horizon: int = documented(
        1, "observations that the policy sees: the present one and obs_horizon - 1 before it", "never"
    )
    horizon: int = documented(8, "actions predicted", "never")
    execute: int = documented(2, "actions played before deciding anew", "free")
    grasp: Grasp = documented(
        "hold", "what is predicted about the hand: hold (desired level) or toggle (official)", "never"
    )
    width: int = documented(512, "units per layer; channels of the first level of a U-Net", "never")
    depth: int = documented(3, "layers, or residual blocks", "never")
    dropout: float = documented(0.0, "dropout in the network")
    denoiser: Denoiser = documented(
        "resmlp", "dp only: resmlp, items (the same, looking at each item with one network) or unet", "never"
    )
    process: Process = documented("flow", "dp only: flow, ddim or ddpm", "never")
    train_steps: int = documented(36, "dp only: diffusion steps in training (ddim, ddpm)", "never")
    sample_steps: int = documented(4, "dp only: steps of one decision", "free")
    restless: float = documented(
        1.0, "dp only: noise of a decision is so many times as wide at a standstill of 2 s", "free"
    )
    pose_noise: NotNegativeFloat = documented(
        0.0, "augmentation: standard deviation of noise on the partner's pose; paper 0.002"
    )
    recombine: NotNegativeFloat = documented(
        0.0, "augmentation: recombined stretches to add, as a share of the recorded windows"
    )
    matching: Matching = documented(
        "both-ends", "recombined stretches begin and end in the same places (paper), or begin there alone: one-end"
    )
    event_weight: AtLeastOne = documented(
        1, "how often windows are drawn in which the hand is about to change, others once", "free"
    )
    grasp_weight: NotNegativeFloat = documented(1.0, "weight of the grasp's numbers in the loss")

    def spec(self, kind: PolicyKind) -> PolicySpec:
        """The network's description. Raises DataError for what cannot be built."""
        names = set(PolicySpec.model_fields) - {"kind"}
        return _described(PolicySpec, {"kind": kind} | {name: getattr(self, name) for name in names})

    def check(self) -> None:
        super().check()
        if self.event_weight > 1 and self.grasp != "hold":
            raise DataError("--event-weight goes by hold levels; train with --grasp hold")


_PAPER = {
    "layout": "map-v1", "obs_horizon": 2, "horizon": 8, "execute": 4, "grasp": "toggle",
    "epochs": 1000, "batch": 1024, "rate": 1e-3, "warmup": 0, "decay": 0.0, "clip": 0.0, "precision": "fp32",
}  # fmt: skip
_POLICY_PRESETS: dict[tuple[str, str], dict[str, Any]] = {
    ("mlp", "fast"): {"width": 512},
    ("gru", "fast"): {"width": 256, "obs_horizon": 4, "horizon": 4, "depth": 2},
    ("dp", "fast"): {"denoiser": "items", "restless": 2.0},
    ("mlp", "paper"): {**_PAPER, "width": 2048},
    ("gru", "paper"): {**_PAPER, "width": 2048, "horizon": 4},
    ("dp", "paper"): {
        **_PAPER, "denoiser": "unet", "process": "ddpm", "width": 128, "dropout": 0.05, "warmup": 500,
        "sample_steps": 36,
    },
}  # fmt: skip


def policy_preset(kind: str, preset: str) -> PolicyConfig:
    """The configuration of `mlp`, `gru` or `dp` by preset: the paper's numbers, or ours."""
    return PolicyConfig(**_POLICY_PRESETS[kind, preset])


@dataclass(frozen=True, kw_only=True)
class BassConfig(Optimisation):
    """The simulator of BASS and how candidates are chosen with it."""

    dynamics: DynamicsKind = documented("vae", "vae (the paper's two autoencoders) or gru (its baseline)", "never")
    width: int = documented(192, "units per layer", "never")
    latent: int = documented(64, "latent dimensions", "never")
    residual: bool = documented(True, "predict the change of the state instead of the state", "never")
    rigid: bool = documented(True, "items move as one body with who holds them, instead of being predicted", "never")
    grasping: bool = documented(True, "what a press does is calculated, instead of being predicted", "never")
    order: Order = documented(
        "joint", "joint, fine-tuned (second autoencoder from the first) or separate; see the paper", "never"
    )
    own: int = documented(8, "own candidates", "free")
    partner: int = documented(2, "guesses of the partner's chunk", "free")
    combine: Combine = documented("product", "product (each with each) or independent (pairs)", "free")
    score: SelectionScore = documented(
        "value", "nfd, nfd+ac, or value: what is done and what is expected to follow", "free"
    )
    depth: int = documented(8, "ticks simulated", "free")
    value_width: int = documented(256, "score value: units per layer of the value network", "never")
    value_members: int = documented(
        4, "score value: networks, each on batches of its own, whose mean is the value", "never"
    )
    value_updates: AtLeastOne = documented(800, "score value: gradient steps of the value network", "free")
    discount: float = documented(0.98, "score value: what progress is worth a tick later", "never")

    def spec(self) -> DynamicsSpec:
        """The network's description. Raises DataError for what cannot be built."""
        names = ("width", "latent", "residual", "rigid", "grasping")
        return _described(DynamicsSpec, {"kind": self.dynamics} | {name: getattr(self, name) for name in names})

    def selection(self) -> SelectionSpec:
        """How candidates are chosen. Raises DataError for numbers out of bounds."""
        names = ("own", "partner", "combine", "score", "depth")
        return _described(SelectionSpec, {name: getattr(self, name) for name in names})

    def value_spec(self) -> ValueSpec:
        """The value network's description. Raises DataError for what cannot be built."""
        options = {"width": "value_width", "members": "value_members", "discount": "discount"}
        values = {name: getattr(self, option) for name, option in options.items()}
        return _described(ValueSpec, values, options)

    def check(self) -> None:
        super().check()
        self.spec(), self.selection(), self.value_spec()
        if self.order != "joint" and self.dynamics != "vae":
            raise DataError(f"--order {self.order} is for autoencoders; --dynamics {self.dynamics} has none")
        if self.order == "fine-tuned" and self.residual:
            raise DataError("--order fine-tuned needs --residual no: a change is not what the first autoencoder knows")


def bass_preset(preset: str) -> BassConfig:
    """The paper's numbers, or ours for one simulator on all maps."""
    if preset == "paper":
        return BassConfig(
            width=128,
            latent=32,
            residual=False,
            rigid=False,
            grasping=False,
            own=4,
            partner=4,
            combine="independent",
            score="nfd",
            depth=4,
            epochs=1000,
            warmup=0,
        )
    return BassConfig()


def _described(model: type[ModelT], values: Mapping[str, object], options: Mapping[str, str] = SAME_NAMES) -> ModelT:
    """A description from its values; `options` names those that are called otherwise on the command line."""
    try:
        return model.model_validate(values)
    except ValidationError as error:
        raise DataError(_sentence(error, options)) from error


def _sentence(error: ValidationError, options: Mapping[str, str] = SAME_NAMES) -> str:
    """The first thing that is wrong: `--batch 0: input should be greater than or equal to 1`."""
    first = error.errors()[0]
    said = first["msg"].removeprefix("Value error, ")
    if not first["loc"]:
        return said
    name = str(first["loc"][0])
    return f"--{options.get(name, name).replace('_', '-')} {first['input']}: {said[0].lower()}{said[1:]}"
