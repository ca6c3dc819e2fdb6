"""`movingout train mlp|gru|dp|bass …`: from recordings to an agent that can take a seat."""

import argparse
import dataclasses
import importlib.util
import json
import sys
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

from agents.checkpoint import SHIPPED, Checkpoint, find_checkpoint, folder_name
from agents.errors import DataError
from agents.policy_spec import PolicySpec
from agents.training.config import (
    PRESETS,
    BassConfig,
    Optimisation,
    PolicyConfig,
    add_fields,
    bass_preset,
    overridden,
    policy_preset,
)

if TYPE_CHECKING:
    from collections.abc import Iterator

    from agents.corrections import Correction
    from agents.dataset import Piece, Trajectory
    from agents.training.simulators import Simulator
    from agents.training.values import ValueFile

KINDS = {
    "mlp": "the paper's MLP",
    "gru": "the paper's GRU",
    "dp": "Diffusion Policy, with the U-Net or the fast denoiser",
    "bass": "BASS: a simulator, to choose among a policy's candidates",
}


def configure(parser: argparse.ArgumentParser) -> None:
    """One sub-command per kind, its options made from the kind's configuration."""
    kinds = parser.add_subparsers(dest="kind", required=True, metavar="KIND")
    for kind, what in KINDS.items():
        sub = kinds.add_parser(kind, help=what, description=f"Train {what}.")
        _common(sub, default_id=f"{kind}@mine")
        sub.add_argument("--preset", choices=PRESETS, default="fast", help="the paper's numbers or ours (default fast)")
        if kind == "bass":
            sub.add_argument("--base", required=True, help="id of the policy whose candidates are chosen among")
            sub.add_argument("--simulator", default="", help="id of a BASS agent whose simulator to take; trains none")
            sub.add_argument("--value", default="", help="id of a BASS agent whose value network to take; trains none")
        add_fields(sub, BassConfig if kind == "bass" else PolicyConfig)


def _common(parser: argparse.ArgumentParser, default_id: str) -> None:
    parser.add_argument(
        "recordings",
        nargs="*",
        type=Path,
        help="recordings (*.mcap), expert's labels (*.corrections.npz) or folders of them",
    )
    parser.add_argument("--id", default=default_id, help=f"id of the new agent (default {default_id})")
    parser.add_argument("--name", default="", help="name shown in the lobby (default: made from the kind)")
    parser.add_argument("--population", default="", help="a word on whose recordings these are, for the card")
    parser.add_argument("--data", type=Path, default=Path("data"), help="data folder (default ./data)")
    parser.add_argument("--json", action="store_true", help="print one JSON document about the result")


def run(args: argparse.Namespace) -> int:
    """Train, export, write DATA/models/<id>."""
    _require_torch()
    checkpoint = _bass(args) if args.kind == "bass" else _policy(args, _material(args.recordings))
    training = checkpoint.card.training
    if args.json:
        print(json.dumps({"id": args.id, "folder": str(checkpoint.folder), **training.model_dump()}))
    else:
        runs = _run_folder(args)
        print(
            f"{args.id}: trained on {training.episodes} episodes, in {checkpoint.folder}; tensorboard --logdir {runs}"
        )
    return 0


@dataclass(frozen=True, slots=True)
class _Material:
    """What there is to learn from: recordings, and episodes that an expert labelled."""

    files: list[Path]
    trajectories: list["Trajectory"]
    corrections: list["Correction"]

    @property
    def episodes(self) -> list["Trajectory"]:
        """All episodes, whoever acted in them."""
        return [*self.trajectories, *(one.trajectory for one in self.corrections)]


def _material(places: list[Path]) -> _Material:
    """Read everything there. Raises DataError when there is nothing."""
    from agents.corrections import SUFFIX, load_correction
    from agents.dataset import read_trajectories, recording_files

    if not places:
        raise DataError("name recordings to learn from, or folders of them; `movingout demos label` makes some")
    files = recording_files(places, (".mcap", SUFFIX))
    labelled = [file for file in files if file.name.endswith(SUFFIX)]
    recordings = [file for file in files if file not in labelled]
    return _Material(files, read_trajectories(recordings), [load_correction(file) for file in labelled])


def _policy(args: argparse.Namespace, material: _Material) -> Checkpoint:
    from agents.corrections import correction_pieces
    from agents.dataset import data_hash, trajectory_pieces, windows_of
    from agents.training.policies import Provenance, save_policy, train_policy

    config = overridden(policy_preset(args.kind, args.preset), args)
    spec = config.spec(args.kind)
    if material.corrections and spec.grasp != "hold":
        raise DataError("an expert's labels say which hold level it wants; train with --grasp hold")
    recorded = trajectory_pieces(material.trajectories, spec.layout, spec.grasp)
    labelled = correction_pieces(material.corrections, spec.layout)
    extra = _recombined(material, config, spec) if config.recombine else iter(())
    windows = windows_of(chain(recorded, labelled, extra))
    source = Provenance(
        data_sha256=data_hash(material.files),
        population=args.population or f"{len(windows.names)} participants",
        episodes=len(material.files),
        maps=tuple(sorted({walk.map.name for walk in material.episodes})),
    )
    _write_config(args, config)
    policy = train_policy(args.kind, config, windows, _run_folder(args))
    name = args.name or f"{args.kind.upper()} {args.id.rpartition('@')[2]}"
    description = f"{args.kind.upper()} trained on {source.episodes} episodes of {source.population}."
    folder = args.data / "models" / folder_name(args.id)
    return save_policy(folder, args.id, policy, config, windows, source, args.preset, name, description)


def _recombined(material: _Material, config: PolicyConfig, spec: PolicySpec) -> "Iterator[Piece]":
    """The paper's recombination: as many ticks more as `config.recombine` says, each piece confirmed by the engine."""
    from agents.bass.recombination import LENGTH, Part, augmentation
    from agents.corrections import taught_stretches

    parts = [
        Part(walk, seat, walk.targets(seat, spec.grasp), ((0, walk.ticks),))
        for walk in material.trajectories
        for seat in (0, 1)
    ]
    parts += [Part(one.trajectory, one.seat, one.labels, tuple(taught_stretches(one))) for one in material.corrections]
    count = round(config.recombine * sum(part.ticks for part in parts) / LENGTH)
    found, report = augmentation(parts, count, config.seed)
    print(f"recombination: {report.valid} of {report.tried} pieces valid ({report.share:.1%})", file=sys.stderr)
    for piece, walk in found:
        seat = piece.own.seat
        yield walk.participants[seat], walk.features(seat, spec.layout), piece.targets


def _bass(args: argparse.Namespace) -> Checkpoint:
    from agents.training.simulators import save_bass

    config = overridden(bass_preset(args.preset), args)
    config.selection()  # refused before hours of training, not after
    base = find_checkpoint(args.base, args.data / "models", SHIPPED)
    trains = not args.simulator or (config.score == "value" and not args.value)
    episodes = _material(args.recordings).episodes if trains else []
    _write_config(args, config)
    simulator = _simulator(args, config, base, episodes)
    value = _value(args, config, episodes) if config.score == "value" else None
    name = args.name or f"BASS {args.id.rpartition('@')[2]}"
    by = "what is done by then and expected to follow" if value else config.score.upper()
    description = (
        f"{base.card.name} with simulation and selection: of {config.own} candidates, each simulated with "
        f"{config.partner} guesses of the partner's, the best by {by}."
    )
    folder = args.data / "models" / folder_name(args.id)
    return save_bass(folder, args.id, base, simulator, value, config, name, description)


def _simulator(
    args: argparse.Namespace, config: BassConfig, base: Checkpoint, episodes: list["Trajectory"]
) -> "Simulator":
    from agents.training.simulators import exported, simulator_of, train_dynamics, transitions_of

    grasp = base.card.policy.grasp
    if args.simulator:
        return simulator_of(find_checkpoint(args.simulator, args.data / "models", SHIPPED), config.depth, grasp)
    return exported(train_dynamics(config, transitions_of(episodes), _run_folder(args)), config.depth, grasp)


def _value(args: argparse.Namespace, config: BassConfig, episodes: list["Trajectory"]) -> "ValueFile":
    from agents.training.values import exported_value, returns_of, train_value, value_of

    if args.value:
        return value_of(find_checkpoint(args.value, args.data / "models", SHIPPED))
    returns = returns_of(episodes, config.discount)
    return exported_value(train_value(config, returns, _run_folder(args) / "value"))


def _run_folder(args: argparse.Namespace) -> Path:
    folder: Path = args.data / "runs" / folder_name(args.id)
    return folder


def _write_config(args: argparse.Namespace, config: Optimisation) -> None:
    folder = _run_folder(args)
    folder.mkdir(parents=True, exist_ok=True)
    text = json.dumps({"kind": args.kind, **dataclasses.asdict(config)}, indent=1)
    (folder / "config.json").write_text(text, encoding="utf-8")


def _require_torch() -> None:
    if importlib.util.find_spec("torch") is None:
        raise DataError("training needs the extra `train`; install it with: pip install 'moving-out-live[train]'")
