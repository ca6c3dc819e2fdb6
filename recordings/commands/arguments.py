"""What the sub-commands of `movingout recordings` have in common. Readers of options raise ArgumentTypeError."""

import argparse
import contextlib
import json
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from movingout.recordings.errors import RecordingError
from movingout.recordings.storage.finished import SUFFIX
from movingout.recordings.storage.listing import recordings_below

USUAL_DATA = Path("data")
MOST_NAMED = 20  # folders, and players where none matches


def add_data(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--data", type=Path, default=USUAL_DATA, metavar="DIR", help="default: ./data")


def data_folder(args: argparse.Namespace) -> Path:
    """The data folder; only the usual one may be missing, before the first game. Raises RecordingError."""
    data: Path = args.data
    if data != USUAL_DATA and not data.exists():
        raise RecordingError(f"there is no folder {data}; --data names one")
    return data


def add_paths(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "paths", nargs="+", type=Path, metavar="FILE|DIR", help="recordings, or folders with some in or below them"
    )


def add_styles(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--styles", type=Path, metavar="FILE.csv",
        help="with --by style: lines participant,style (default: of scripted people, A01 to C20, their population)",
    )  # fmt: skip


def add_challenge(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--challenge", type=int, choices=(1, 2),
        help="only episodes on maps as designed (1), or only those on varied maps (2); default: both",
    )  # fmt: skip


def print_json(document: dict[str, Any]) -> None:
    sys.stdout.write(json.dumps(document, indent=2) + "\n")


def expanded(paths: Iterable[Path]) -> list[Path]:
    """The files named, and the recordings in the folders named and below them; each once."""
    files = [file for path in paths for file in (recordings_below(path) if path.is_dir() else [path])]
    return list(dict.fromkeys(files))


def places_below(folder: Path, finished: bool = False) -> str:
    """How many recordings lie in the folders below one and in which, empty for none: "2 below it, in a/b, a/c".

    With `finished`, journals are none.
    """
    below: list[Path] = []
    with contextlib.suppress(RecordingError):
        below = [path for path in recordings_below(folder) if path.parent != folder] if folder.exists() else []
    below = [path for path in below if path.name.endswith(SUFFIX)] if finished else below
    if not below:
        return ""
    folders = sorted({str(path.parent) for path in below})
    more = f" and {len(folders) - MOST_NAMED} more" if len(folders) > MOST_NAMED else ""
    return f"{len(below)} below it, in {', '.join(folders[:MOST_NAMED])}{more}"


def positive(text: str) -> int:
    """The value of an option that counts something."""
    try:
        value = int(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number") from error
    if value < 1:
        raise argparse.ArgumentTypeError("it must be at least 1")
    return value


def share(text: str) -> float:
    """The value of an option that takes a part of everything."""
    try:
        value = float(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"{text!r} is no share; write 0.2 for a fifth") from error
    if not 0 <= value < 1:
        raise argparse.ArgumentTypeError("a share is from 0 up to, but not including, 1")
    return value
