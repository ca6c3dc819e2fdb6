"""`movingout train mlp|gru|dp …`: from recordings to an agent that can take a seat."""

import argparse
import dataclasses
import importlib.util
import json
from pathlib import Path

from agents.checkpoint import folder_name
from agents.errors import DataError

POLICIES = ("mlp", "gru", "dp")


def configure(parser: argparse.ArgumentParser) -> None:
    """One sub-command per kind, its options made from the kind's configuration."""
    _require_torch()
    from agents.training.config import PRESETS, PolicyConfig, add_fields

    kinds = parser.add_subparsers(dest="kind", required=True, metavar="KIND")
    helps = {"mlp": "the paper's MLP", "gru": "the paper's GRU", "dp": "Diffusion Policy: U-Net or fast denoiser"}
    for kind in POLICIES:
        sub = kinds.add_parser(kind, help=helps[kind], description=f"Train {helps[kind]}.")
        _common(sub, default_id=f"{kind}@mine")
        sub.add_argument("--preset", choices=PRESETS, default="fast", help="the paper's numbers or ours (default fast)")
        add_fields(sub, PolicyConfig)


def _common(parser: argparse.ArgumentParser, default_id: str) -> None:
    parser.add_argument("recordings", nargs="+", type=Path, help="recordings (*.mcap) or folders of them")
    parser.add_argument("--id", default=default_id, help=f"id of the new agent (default {default_id})")
    parser.add_argument("--name", default="", help="name shown in the lobby (default: made from the kind)")
    parser.add_argument("--population", default="", help="a word on whose recordings these are, for the card")
    parser.add_argument("--data", type=Path, default=Path("data"), help="data folder (default ./data)")
    parser.add_argument("--json", action="store_true", help="print one JSON document about the result")


def run(args: argparse.Namespace) -> int:
    """Train, export, write DATA/models/<id>."""
    from agents.dataset import data_hash, read_trajectories, recording_files, trajectory_windows
    from agents.training.config import overridden, policy_preset
    from agents.training.policies import Provenance, save_policy, train_policy

    config = overridden(policy_preset(args.kind, args.preset), args)
    spec = config.spec(args.kind)
    files = recording_files(args.recordings)
    trajectories = read_trajectories(files)
    windows = trajectory_windows(trajectories, spec.layout, spec.grasp)
    source = Provenance(
        data_sha256=data_hash(files),
        population=args.population or f"{len(windows.names)} participants",
        episodes=len(trajectories),
        maps=tuple(sorted({trajectory.map.name for trajectory in trajectories})),
    )
    folder: Path = args.data / "runs" / folder_name(args.id)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "config.json").write_text(json.dumps({"kind": args.kind, **dataclasses.asdict(config)}, indent=1))
    policy = train_policy(args.kind, config, windows, folder)
    checkpoint = save_policy(
        args.data / "models" / folder_name(args.id),
        args.id,
        policy,
        config,
        windows,
        source,
        args.preset,
        args.name or f"{args.kind.upper()} {args.id.rpartition('@')[2]}",
        f"{args.kind.upper()} trained on {source.episodes} episodes of {source.population}.",
    )
    if args.json:
        print(json.dumps({"id": args.id, "folder": str(checkpoint.folder), "windows": len(windows)}))
    else:
        print(f"{args.id}: {len(windows)} windows, in {checkpoint.folder}; curves: tensorboard --logdir {folder}")
    return 0


def _require_torch() -> None:
    if importlib.util.find_spec("torch") is None:
        raise DataError("training needs the extra `train`; install it with: pip install 'moving-out-live[train]'")
