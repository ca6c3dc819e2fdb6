"""The kinds that are a policy network alone: MLP, GRU and Diffusion Policy. They differ in network and presets."""

import argparse
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from itertools import chain
from typing import TYPE_CHECKING, Any, get_args

from movingout.agents.agent_options import ticks_between_decisions, yes_or_no
from movingout.agents.base import Agent
from movingout.agents.checkpoint.card import Card
from movingout.agents.checkpoint.checkpoint import Checkpoint
from movingout.agents.checkpoint.policy_spec import PolicySpec
from movingout.agents.data.dataset import SeatChoice, SeatSamples
from movingout.agents.errors import CheckpointError, DataError
from movingout.agents.inference.mirror import FeatureMirror
from movingout.agents.kinds.kind import AgentKind, Trained
from movingout.agents.observation.features import FeatureSet
from movingout.agents.policies.config import PolicyConfig, RegressionConfig, shape_of
from movingout.agents.training.run import TrainingRun
from movingout.agents.training.run_folder import NO_CHANGES
from movingout.agents.training.training_data import TrainingData
from movingout.maps.suggestion import counted

if TYPE_CHECKING:
    from movingout.agents.policies.policy import Policy

Build = Callable[[PolicySpec], "Policy"]
"""Makes the network that a spec describes, with fresh weights."""

_PAPER: Mapping[str, Any] = {
    "layout": "map-v1", "obs_horizon": 2, "horizon": 8, "execute": 4, "grasp": "toggle", "epochs": 1000, "batch": 1024,
    "rate": 1e-3, "warmup": 0, "decay": 0.0, "clip": 0.0, "precision": "fp32", "width": 2048,
}  # fmt: skip
"""What the paper's policies have in common."""


def policy_kind(
    name: str, summary: str, build: Build, fast: PolicyConfig, paper: PolicyConfig
) -> AgentKind[PolicyConfig]:
    """The record of a policy that is trained from windows and plays as an ONNX graph."""
    return AgentKind(
        name=name,
        summary=summary,
        presets={"fast": fast, "paper": paper},
        add_options=_add_options,
        option_names=("seats", "start"),
        train=lambda run: _train(name, build, run),
        load=load_policy,
        check=check_policy,
    )


def load_policy(checkpoint: Checkpoint, execute: int = 0, mirrored: bool | str = False) -> Agent:
    """The agent of a checkpoint. `execute`: ticks between decisions; 0 means what the card says.

    `mirrored`: yes draws half of the decisions through the mirror (`agents.inference.mirror`).
    """
    from movingout.agents.inference.network import shared_policy_network
    from movingout.agents.inference.policy_agent import PolicyAgent

    spec = checkpoint.card.network
    return PolicyAgent(
        spec, shared_policy_network(spec, checkpoint.read("policy.onnx")), execute, yes_or_no("mirrored", mirrored)
    )


def check_policy(card: Card, execute: int = 0, mirrored: bool | str = False) -> None:
    """Raises AgentError for options that `load_policy` refuses."""
    ticks_between_decisions(execute, card.network.horizon)
    if yes_or_no("mirrored", mirrored):
        FeatureMirror(FeatureSet.of(card.network))


def _train(kind: str, build: Build, run: TrainingRun[PolicyConfig]) -> Trained:
    """From recordings to a checkpoint: read, cut into windows, fit, export."""
    from movingout.agents.data.dataset import windows_of
    from movingout.agents.policies.export import save_policy
    from movingout.agents.policies.training import train_policy

    base = _base(kind, run)
    if base:
        run = _shaped(run, base)
    config, spec = run.config, run.config.spec(kind)
    first = weighted_policy(base) if base else None
    seats: SeatChoice = run.options.seats
    data = run.read_data()
    data.check_seen(spec.layout)
    pieces = data.pieces(spec, seats)
    if left_out := data.left_out(seats):
        count = 2 * len(data.trajectories)
        run.tell(f"--seats {seats}: {left_out} of {count} seats are not learned from")
    before = run.begin_on(data, dict.fromkeys(shape_of(spec), "free") if base else NO_CHANGES)  # given by the base
    windows = windows_of(chain(pieces, _recombined(run, data, spec)))
    fitted = train_policy(build, spec, config, windows, run.folder, first)
    run.check_learned(before, fitted, "--updates")
    training = run.training(data, windows.names, len(windows), fitted.updates, base.card if base else None)
    beginning = f", starting from {base.card.id}" if base else ""
    others, learned = run.others_before(), counted(training.episodes, "episode")
    description = f"{kind.upper()} trained on {learned} of {training.population}{beginning}{others}."
    maps = run.maps({trajectory.map.name for trajectory in data.episodes})
    checkpoint = save_policy(run.model_folder, run.agent_id, fitted.network, maps, training, run.name, description)
    return Trained(checkpoint, training)


def _recombined(run: TrainingRun[PolicyConfig], data: TrainingData, spec: PolicySpec) -> Iterator[SeatSamples]:
    """Samples by the paper's recombination: `config.recombine` times the recorded ticks."""
    from movingout.agents.bass.recombination import LENGTH, augmentation

    config, seen = run.config, FeatureSet.of(spec)
    if not config.recombine:
        return
    parts = data.parts(spec, run.options.seats)
    count = round(config.recombine * sum(part.ticks for part in parts) / LENGTH)
    found, report = augmentation(parts, count, config.seed, config.matching, config.confirm)
    run.tell(f"recombination: {report.valid} of {report.tried} pieces valid ({report.share:.1%})")
    for piece, trajectory in found:
        seat = piece.own.seat
        yield SeatSamples(
            trajectory.whose(seat),
            trajectory.features(seat, seen),
            piece.targets,
            trajectory.angles(seat, seen),
        )


def _add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--seats",
        choices=get_args(SeatChoice),
        default="acting",
        help="seats of recordings to learn from: acting (default; no idle seats and ghosts), human, or all",
    )
    parser.add_argument(
        "--start",
        metavar="ID",
        default="",
        help="start from the weights of this agent instead of random ones; the network is then shaped as its is",
    )


def _base(kind: str, run: TrainingRun[PolicyConfig]) -> Checkpoint | None:
    """The agent of --start. Raises CheckpointError or DataError when it cannot be trained on."""
    if not run.options.start:
        return None
    base = run.find(run.options.start)
    if base.card.network.kind != kind or base.card.kind != kind:
        raise DataError(f"--start {base.card.id}: it is of kind {base.card.kind}; use `train {base.card.kind}`")
    return base


def _shaped(run: TrainingRun[PolicyConfig], base: Checkpoint) -> TrainingRun[PolicyConfig]:
    """The same run with a network as that of its base. Raises DataError for options that say another one."""
    for name, value in shape_of(base.card.network).items():
        if name in run.options and (typed := getattr(run.config, name)) != value:
            raise DataError(
                f"--{name.replace('_', '-')} {typed}: the network is that of --start {base.card.id}, which has "
                f"{value if value != '' else 'none'}; leave it out"
            )
    return replace(run, config=run.config.shaped(base.card.network))


def weighted_policy(checkpoint: Checkpoint) -> "Policy":
    """The network of a checkpoint with its weights, ready to be trained on.

    Raises CheckpointError or DataError when the checkpoint has no weights that fit.
    """
    import torch
    from safetensors import SafetensorError
    from safetensors.torch import load

    network = build_policy(checkpoint.card.network)
    try:
        found = load(checkpoint.read("policy.safetensors"))
    except SafetensorError as error:
        raise CheckpointError(
            f"policy.safetensors of checkpoint {checkpoint.card.id} cannot be read: {error}"
        ) from error
    weights = {name: tensor.to(torch.float32) for name, tensor in found.items()}
    try:
        network.load_state_dict(weights)
    except RuntimeError as error:
        raise DataError(
            f"{checkpoint.card.id} has other weights than a policy of kind {checkpoint.card.kind}; "
            "take the agent it was made from"
        ) from error
    return network


def build_policy(spec: PolicySpec) -> "Policy":
    """The network of a shipped kind, with fresh weights."""
    return _NETWORKS[spec.kind](spec)


def _mlp(spec: PolicySpec) -> "Policy":
    from movingout.agents.policies.behaviour_cloning import MlpPolicy

    return MlpPolicy(spec)


def _gru(spec: PolicySpec) -> "Policy":
    from movingout.agents.policies.behaviour_cloning import GruPolicy

    return GruPolicy(spec)


def _diffusion_policy(spec: PolicySpec) -> "Policy":
    from movingout.agents.policies.diffusion_policy import DiffusionPolicy

    return DiffusionPolicy(spec)


MLP = policy_kind("mlp", "the paper's MLP", _mlp, fast=RegressionConfig(width=512), paper=RegressionConfig(**_PAPER))
GRU = policy_kind(
    "gru",
    "the paper's GRU",
    _gru,
    fast=RegressionConfig(width=256, obs_horizon=4, horizon=4, depth=2),
    paper=RegressionConfig(**{**_PAPER, "horizon": 4}),
)
DP = policy_kind(
    "dp",
    "Diffusion Policy, with the U-Net or the fast denoiser",
    _diffusion_policy,
    fast=PolicyConfig(denoiser="items", restless=2.0),
    paper=PolicyConfig(**{
        **_PAPER, "denoiser": "unet", "process": "ddpm", "width": 128, "dropout": 0.05, "warmup": 500,
        "sample_steps": 36,
    }),
)  # fmt: skip
_NETWORKS: dict[str, Build] = {MLP.name: _mlp, GRU.name: _gru, DP.name: _diffusion_policy}
