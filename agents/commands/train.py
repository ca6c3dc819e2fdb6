"""`movingout train mlp|gru|dp|bass …`: from recordings to an agent that can take a seat."""

import argparse
import datetime
import importlib.util
import json
import sys
from collections.abc import Collection
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, get_args

from movingout.agents.checkpoint.checkpoint import (
    SHIPPED,
    Card,
    Checkpoint,
    Training,
    check_labels,
    check_room,
    find_checkpoint,
    folder_name,
)
from movingout.agents.checkpoint.policy_spec import Grasp, PolicySpec
from movingout.agents.data.dataset import SeatChoice
from movingout.agents.errors import DataError
from movingout.agents.training import run as runs
from movingout.agents.training.config import PRESETS, BassConfig, Optimisation, PolicyConfig, bass_preset, policy_preset
from movingout.agents.training.material import Material, read_material
from movingout.agents.training.options import add_fields, overridden
from movingout.world.exactness import inexact_engine

if TYPE_CHECKING:
    from collections.abc import Iterator

    from torch import nn

    from movingout.agents.data.dataset import Piece
    from movingout.agents.training.loop import Fitted
    from movingout.agents.training.simulators import Simulator
    from movingout.agents.training.values import ValueFile

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
        else:
            sub.add_argument(
                "--seats",
                choices=get_args(SeatChoice),
                default="acting",
                help="whom to learn from in recordings: all who act (default; no idle seats and ghosts), human, or all",
            )
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
    parser.add_argument(
        "--go-on",
        action="store_true",
        help="go on with what this id has learned, although the data or the way to train is another",
    )
    parser.add_argument("--data", type=Path, default=Path("data"), help="data folder (default ./data)")
    parser.add_argument("--json", action="store_true", help="print one JSON document about the result")


def run(args: argparse.Namespace) -> int:
    """Train, export, write DATA/models/<id>."""
    check_labels(args.id, args.name, args.population)
    check_room(_model_folder(args), args.id)
    _require_torch()
    if caution := inexact_engine():
        print(f"movingout: {caution}", file=sys.stderr)
    checkpoint = _bass(args) if args.kind == "bass" else _policy(args)
    runs.finish(_run_folder(args), checkpoint)
    training = _new_in(checkpoint.card, args)
    if args.json:
        print(json.dumps({"id": args.id, "folder": str(checkpoint.folder), **training.model_dump()}))
        return 0
    where = f"in {checkpoint.folder}; tensorboard --logdir {_run_folder(args)}"
    print(f"{args.id}: trained on {training.episodes} episodes, {where}")
    if args.data.resolve() != Path("data").resolve():
        print(f"to play with it, copy {checkpoint.folder} to data/models: `play`, `match` and `agents` look there")
    return 0


def _new_in(card: Card, args: argparse.Namespace) -> Training:
    """Where those weights come from that were trained now, and not taken from another agent; else the policy's."""
    simulator = None if getattr(args, "simulator", "") else card.dynamics_training
    value = None if getattr(args, "value", "") else card.value_training
    return simulator or value or card.training


def _policy(args: argparse.Namespace) -> Checkpoint:
    from movingout.agents.data.dataset import windows_of
    from movingout.agents.training.policies import save_policy, train_policy

    config = overridden(policy_preset(args.kind, args.preset), args)
    spec = config.spec(args.kind)
    material = read_material(args.recordings)
    pieces = material.pieces(spec, args.seats)
    if left_out := material.left_out(args.seats):
        seats = 2 * len(material.trajectories)
        print(f"--seats {args.seats}: {left_out} of {seats} seats are not learned from", file=sys.stderr)
    before = runs.begin(_run_folder(args), _about(args, material.sha256), config, args.go_on)
    windows = windows_of(chain(pieces, _recombined(args, material, config, spec)))
    fitted = train_policy(args.kind, config, windows, _run_folder(args))
    _check_learned(args, material, before, fitted, "--updates")
    training = _training(args, config, material, windows.names, len(windows), fitted.updates)
    name = args.name or f"{args.kind.upper()} {args.id.rpartition('@')[2]}"
    description = f"{args.kind.upper()} trained on {training.episodes} episodes of {training.population}."
    maps = {walk.map.name for walk in material.episodes}
    return save_policy(_model_folder(args), args.id, fitted.network, maps, training, name, description)


def _recombined(
    args: argparse.Namespace, material: Material, config: PolicyConfig, spec: PolicySpec
) -> "Iterator[Piece]":
    """The paper's recombination: as many ticks more as `config.recombine` says, each piece confirmed by the engine."""
    from movingout.agents.bass.recombination import LENGTH, augmentation
    from movingout.agents.data.dataset import person

    if not config.recombine:
        return
    parts = material.parts(spec, args.seats)
    count = round(config.recombine * sum(part.ticks for part in parts) / LENGTH)
    found, report = augmentation(parts, count, config.seed, config.matching)
    print(f"recombination: {report.valid} of {report.tried} pieces valid ({report.share:.1%})", file=sys.stderr)
    for piece, walk in found:
        seat = piece.own.seat
        yield person(walk.participants[seat]), walk.features(seat, spec.layout), piece.targets


def _bass(args: argparse.Namespace) -> Checkpoint:
    from movingout.agents.training.simulators import save_bass

    config = overridden(bass_preset(args.preset), args)
    base = _found(args, args.base)
    grasp, horizon = base.card.policy.grasp, base.card.policy.horizon
    if config.depth > horizon:
        raise DataError(
            f"{args.base} predicts {horizon} ticks, so --depth {config.depth} is too far; --depth {horizon}"
        )
    if args.value and config.score != "value":
        raise DataError(f"--value {args.value} is for --score value, not for --score {config.score}")
    simulator, value = _taken(args, config, grasp)
    if simulator is None or (value is None and config.score == "value"):
        material = read_material(args.recordings)
        before = runs.begin(_run_folder(args), _about(args, material.sha256), config, args.go_on)
        simulator = simulator or _simulator(args, config, material, grasp, before)
        value = value or (_value(args, config, material, before) if config.score == "value" else None)
    else:
        runs.begin(_run_folder(args), _about(args), config, args.go_on)
    by = "what is done by then and expected to follow" if value else config.score.upper()
    description = (
        f"{base.card.name} with simulation and selection: of {config.own} candidates, each simulated with "
        f"{config.partner} guesses of the partner's, the best by {by}."
    )
    name = args.name or f"BASS {args.id.rpartition('@')[2]}"
    return save_bass(_model_folder(args), args.id, base, simulator, value, config, name, description)


def _taken(args: argparse.Namespace, config: BassConfig, grasp: Grasp) -> "tuple[Simulator | None, ValueFile | None]":
    """The simulator and the value of other agents, where they are named."""
    from movingout.agents.training.simulators import simulator_of
    from movingout.agents.training.values import value_of

    simulator = simulator_of(_found(args, args.simulator), config.depth, grasp) if args.simulator else None
    value = value_of(_found(args, args.value)) if args.value and config.score == "value" else None
    return simulator, value


def _simulator(
    args: argparse.Namespace, config: BassConfig, material: Material, grasp: Grasp, before: str
) -> "Simulator":
    from movingout.agents.training.simulators import exported, train_dynamics, transitions_of

    data = transitions_of(material.episodes)
    fitted = train_dynamics(config, data, _run_folder(args))
    _check_learned(args, material, before, fitted, "--updates")
    training = _training(args, config, material, material.cast, len(data), fitted.updates)
    return exported(fitted.network, config.depth, grasp, training)


def _value(args: argparse.Namespace, config: BassConfig, material: Material, before: str) -> "ValueFile":
    from movingout.agents.training.values import exported_value, returns_of, train_value

    data = returns_of(material.episodes, config.discount)
    fitted = train_value(config, data, _run_folder(args) / "value")
    _check_learned(args, material, before, fitted, "--value-updates")
    training = _training(args, config, material, material.cast, len(data.returns), fitted.updates)
    return exported_value(fitted.network, training)


def _check_learned(
    args: argparse.Namespace, material: Material, before: str, fitted: "Fitted[nn.Module]", option: str
) -> None:
    """Raises DataError when there was nothing left to do, so that a card would name data never learned from.

    `before` is the hash of what the run had until now, `option` the one that would let it learn on.
    """
    if not fitted.made and before not in ("", material.sha256):
        runs.put_back(_run_folder(args), before)
        raise DataError(f"{args.id} has made all of its {fitted.updates} updates; learn on with a larger {option}")


def _training(
    args: argparse.Namespace, config: Optimisation, material: Material, people: Collection[str], rows: int, updates: int
) -> Training:
    """Where weights come from, for the card."""
    return Training(
        preset=args.preset,
        data_sha256=material.sha256,
        population=args.population or f"{len(people)} participants",
        episodes=len(material.files),
        windows=rows,
        updates=updates,
        seed=config.seed,
        created=datetime.datetime.now(datetime.UTC).date().isoformat(),
    )


def _about(args: argparse.Namespace, data_sha256: str = "") -> dict[str, str]:
    """What the run folder says beside the configuration; without data nothing is trained."""
    names = "id", "kind", "preset", "base", "simulator", "value", "seats"
    about = {name: str(value) for name, value in vars(args).items() if name in names}
    return {**about, "data_sha256": data_sha256} if data_sha256 else about


def _found(args: argparse.Namespace, agent_id: str) -> Checkpoint:
    return find_checkpoint(agent_id, args.data / "models", SHIPPED)


def _model_folder(args: argparse.Namespace) -> Path:
    folder: Path = args.data / "models" / folder_name(args.id)
    return folder


def _run_folder(args: argparse.Namespace) -> Path:
    folder: Path = args.data / "runs" / folder_name(args.id)
    return folder


def _require_torch() -> None:
    if importlib.util.find_spec("torch") is None:
        raise DataError("training needs the extra `train`; install it with: pip install 'moving-out-live[train]'")
