"""`movingout recordings verify`: re-simulate recordings and compare all bits."""

import argparse
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from movingout.maps.commands.parser import add_json
from movingout.maps.commands.sentences import tell
from movingout.maps.files.terminal import printable
from movingout.recordings.commands.arguments import add_paths, expanded, positive, print_json
from movingout.recordings.errors import RecordingError
from movingout.recordings.progress import map_in_processes
from movingout.recordings.ray_cluster import map_on_ray
from movingout.recordings.storage.verified import never_verified, not_verified, note_verified
from movingout.recordings.verification import Verification, verify


def configure(parser: argparse.ArgumentParser) -> None:
    add_paths(parser)
    parser.add_argument("--new", action="store_true", help="only those that were not found identical before")
    parser.add_argument("--workers", type=positive, default=os.cpu_count() or 1, help="processes (default: all cores)")
    parser.add_argument("--ray", metavar="auto|ADDRESS", help="work on a Ray cluster instead (extra `cluster`)")
    add_json(parser)
    parser.set_defaults(perform=perform)


def perform(args: argparse.Namespace) -> int:
    """Raises RecordingError where there is nothing to verify."""
    paths = expanded(args.paths)
    if not paths and not (args.new and all(map(never_verified, args.paths))):
        raise RecordingError("no recordings to verify there; name .mcap files or a folder with some")
    if args.new and not (paths := not_verified(paths)):
        print_json({"files": []}) if args.json else print("nothing new to verify")
        return 0
    verdicts = _noted(paths, args) if args.new else [*_verdicts(paths, args)]
    if args.json:
        print_json({"files": [_verdict_json(path, verdict) for path, verdict in zip(paths, verdicts, strict=True)]})
    else:
        for path, verdict in zip(paths, verdicts, strict=True):
            print(printable(_verdict_line(path, verdict)))
        if len(verdicts) > 1:
            equal = sum(map(_holds, verdicts))
            print(f"{equal} of {len(verdicts)} recordings are identical")
    if any(isinstance(verdict, str) for verdict in verdicts):
        return 2
    return int(any(isinstance(verdict, Verification) and not verdict.identical for verdict in verdicts))


def _verdicts(paths: list[Path], args: argparse.Namespace) -> Iterator[Verification | str]:
    if args.ray is None:
        return map_in_processes(_verdict, paths, min(args.workers, len(paths)), "verifying")
    return map_on_ray(args.ray, _verdict, [path.resolve() for path in paths], "verifying")


def _noted(paths: list[Path], args: argparse.Namespace) -> list[Verification | str]:
    """The verdicts. What holds is noted, also what was verified before Ctrl-C."""
    verdicts: list[Verification | str] = []
    try:
        for verdict in _verdicts(paths, args):
            verdicts.append(verdict)
    finally:
        _keep_verified([path for path, verdict in zip(paths, verdicts, strict=False) if _holds(verdict)])
    return verdicts


def _holds(verdict: Verification | str) -> bool:
    return isinstance(verdict, Verification) and verdict.identical


def _keep_verified(paths: list[Path]) -> None:
    """Where that cannot be written, they are verified once more the next time."""
    try:
        note_verified(paths)
    except OSError as error:
        tell(f"cannot note what was verified: {error.strerror or error}")


def _verdict(path: Path) -> Verification | str:
    """The verdict, or why there is none, as a plain value that can be sent between processes."""
    try:
        return verify(path)
    except RecordingError as error:
        return str(error)


def _verdict_line(path: Path, verdict: Verification | str) -> str:
    if isinstance(verdict, str):
        return f"UNREADABLE  {path}: {verdict}"
    notes = "".join(f"; {note}" for note in (verdict.caveat, verdict.damage) if note)
    if verdict.first_divergence is None:
        return f"identical   {path}: {verdict.ticks} ticks equal to the bit{notes}"
    return f"DIVERGES    {path}: {verdict.first_divergence}{notes}"


def _verdict_json(path: Path, verdict: Verification | str) -> dict[str, Any]:
    if isinstance(verdict, str):
        return {"path": str(path), "ticks": 0, "identical": False, "first_divergence": None, "problem": verdict}
    first = verdict.first_divergence
    return {
        "path": str(path),
        "ticks": verdict.ticks,
        "identical": verdict.identical,
        "first_divergence": None
        if first is None
        else {"tick": first.tick, "field": first.field, "recorded": first.recorded, "simulated": first.simulated},
        "caveat": verdict.caveat,
        "damage": verdict.damage,
    }
