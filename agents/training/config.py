"""What a training run is told: one frozen dataclass per kind, every field documented, made into the command line."""

import argparse
import dataclasses
from dataclasses import dataclass, field
from typing import Any, TypeVar

from agents.checkpoint import DynamicsSpec, SelectionSpec
from agents.policy_spec import PolicySpec

PRESETS = ("fast", "paper")
ConfigT = TypeVar("ConfigT", bound="Optimisation")


def documented(default: Any, text: str) -> Any:
    """A dataclass field with its help text."""
    return field(default=default, metadata={"help": text})


@dataclass(frozen=True, kw_only=True)
class Optimisation:
    """How weights are fitted; the same for every network."""

    updates: int = documented(6000, "gradient steps; ignored when epochs is set")
    epochs: int = documented(0, "passes over the training windows instead of a number of updates; 0: use updates")
    batch: int = documented(1024, "windows per update")
    rate: float = documented(1e-3, "peak learning rate of AdamW, reached after the warm-up, then a cosine to 0")
    warmup: int = documented(200, "updates until the peak learning rate")
    decay: float = documented(1e-4, "weight decay")
    clip: float = documented(1.0, "largest norm of the gradient; 0: not clipped")
    ema: float = documented(0.999, "share that the moving average keeps per update; the average is what plays")
    held_out: float = documented(0.1, "share of the participants kept for validation")
    seed: int = documented(0, "seed of initial weights, batches and noise")
    threads: int = documented(1, "CPU threads")
    precision: str = documented("auto", "bf16 (mixed precision), fp32, or auto: bf16 on a GPU, where it is faster")
    evaluate_every: int = documented(500, "updates between validations and resume files")
    window_share: float = documented(1.0, "share of the rows that are used, to try things out quickly")


@dataclass(frozen=True, kw_only=True)
class PolicyConfig(Optimisation):
    """A policy and how it is trained; the fields of the network are those of its card."""

    layout: str = documented("aware-v1", "observation layout: official-v1, map-v1 (walls and goals), aware-v1 (ways)")
    obs_horizon: int = documented(1, "observations that the policy sees: the present one and obs_horizon - 1 before it")
    horizon: int = documented(8, "actions predicted")
    execute: int = documented(2, "actions played before deciding anew")
    grasp: str = documented("hold", "what is predicted about the hand: hold (desired level) or toggle (official)")
    width: int = documented(512, "units per layer; channels of the first level of a U-Net")
    depth: int = documented(3, "layers, or residual blocks")
    dropout: float = documented(0.0, "dropout in the network")
    denoiser: str = documented("resmlp", "dp only: resmlp or unet")
    process: str = documented("flow", "dp only: flow, ddim or ddpm")
    train_steps: int = documented(36, "dp only: diffusion steps in training (ddim, ddpm)")
    sample_steps: int = documented(4, "dp only: steps of one decision")
    restless: float = documented(1.0, "dp only: noise of a decision is so many times as wide at a standstill of 2 s")
    pose_noise: float = documented(0.0, "augmentation: standard deviation of noise on the partner's pose; paper 0.002")
    recombine: float = documented(0.0, "augmentation: recombined stretches to add, as a share of the recorded windows")
    event_weight: int = documented(1, "how often windows are drawn in which the hand is about to change, others once")
    grasp_weight: float = documented(1.0, "weight of the grasp's numbers in the loss")

    def spec(self, kind: str) -> PolicySpec:
        """The network's description. Raises ValidationError (pydantic) for a value out of bounds."""
        names = set(PolicySpec.model_fields) - {"kind"}
        return PolicySpec.model_validate({"kind": kind, **{name: getattr(self, name) for name in names}})


_PAPER = {
    "layout": "map-v1", "obs_horizon": 2, "horizon": 8, "execute": 4, "grasp": "toggle",
    "epochs": 1000, "batch": 1024, "rate": 1e-3, "warmup": 0, "decay": 0.0, "clip": 0.0, "precision": "fp32",
}  # fmt: skip
_POLICY_PRESETS: dict[tuple[str, str], dict[str, Any]] = {
    ("mlp", "fast"): {"width": 512},
    ("gru", "fast"): {"width": 256, "obs_horizon": 4, "horizon": 4, "depth": 2},
    ("dp", "fast"): {"restless": 2.0},
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

    dynamics: str = documented("vae", "vae (the paper's two autoencoders) or gru (its baseline)")
    width: int = documented(192, "units per layer")
    latent: int = documented(64, "latent dimensions")
    residual: bool = documented(True, "predict the change of the state instead of the state")
    rigid: bool = documented(True, "items move as one body with who holds them, instead of being predicted")
    order: str = documented("joint", "joint, fine-tuned (second autoencoder from the first) or separate; see the paper")
    own: int = documented(8, "own candidates")
    partner: int = documented(2, "guesses of the partner's chunk")
    combine: str = documented("product", "product (each with each) or independent (pairs)")
    score: str = documented("value", "nfd, nfd+ac, or value: what is done and what is expected to follow")
    depth: int = documented(8, "ticks simulated")
    value_width: int = documented(256, "score value: units per layer of the value network")
    value_members: int = documented(4, "score value: networks, each on batches of its own, whose mean is the value")
    value_updates: int = documented(800, "score value: gradient steps of the value network")
    discount: float = documented(0.98, "score value: what progress is worth a tick later")

    def spec(self) -> DynamicsSpec:
        """The network's description."""
        names = ("width", "latent", "residual", "rigid")
        return DynamicsSpec.model_validate({"kind": self.dynamics, **{name: getattr(self, name) for name in names}})

    def selection(self) -> SelectionSpec:
        """How candidates are chosen."""
        names = ("own", "partner", "combine", "score", "depth")
        return SelectionSpec.model_validate({name: getattr(self, name) for name in names})


def bass_preset(preset: str) -> BassConfig:
    """The paper's numbers, or ours for one simulator on all maps."""
    if preset == "paper":
        return BassConfig(
            width=128,
            latent=32,
            residual=False,
            rigid=False,
            own=4,
            partner=4,
            combine="independent",
            score="nfd",
            depth=4,
            epochs=1000,
            warmup=0,
        )
    return BassConfig()


def add_fields(parser: argparse.ArgumentParser, config: type[Optimisation]) -> None:
    """One option per field; what is not given is not set, so that a preset keeps its value."""
    group = parser.add_argument_group("configuration (defaults come from the preset)")
    for entry in dataclasses.fields(config):
        group.add_argument(
            f"--{entry.name.replace('_', '-')}",
            dest=entry.name,
            type=_yes_or_no if isinstance(entry.default, bool) else type(entry.default),
            default=argparse.SUPPRESS,
            help=str(entry.metadata["help"]).replace("%", "%%"),
        )


def overridden(config: ConfigT, args: argparse.Namespace) -> ConfigT:
    """`config` with what the command line says."""
    given = {entry.name: vars(args)[entry.name] for entry in dataclasses.fields(config) if entry.name in vars(args)}
    return dataclasses.replace(config, **given)


def _yes_or_no(word: str) -> bool:
    if word not in ("yes", "no"):
        raise argparse.ArgumentTypeError(f"yes or no, not {word!r}")
    return word == "yes"
