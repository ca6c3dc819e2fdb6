"""What a training writes into the folder of its run as it goes: tensors to continue from, and a line per evaluation."""

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from safetensors import SafetensorError
from safetensors.torch import save_file
from torch import Tensor

from movingout.agents.errors import DataError
from movingout.maps.files.output_file import draft_of

LOSSES = "losses.jsonl"


@contextmanager
def written(path: Path) -> Iterator[None]:
    """Raises DataError where a file, or one in a folder, cannot be written within the block: the disk may be full."""
    try:
        yield
    except (OSError, SafetensorError) as error:
        reason = getattr(error, "strerror", None) or error
        raise DataError(
            f"cannot write {path}: {reason}; what was saved before is kept, so that the same command continues there"
        ) from error


def save_tensors(path: Path, tensors: Mapping[str, Tensor]) -> None:
    """Write a safetensors file whole, or not at all. Raises DataError."""
    with written(path), draft_of(path) as draft:
        save_file(dict(tensors), draft)


def append_losses(folder: Path, values: Mapping[str, float]) -> None:
    """Add a line to `losses.jsonl`. Raises DataError."""
    path = folder / LOSSES
    with written(path), path.open("a", encoding="utf-8") as curve:
        curve.write(json.dumps(values) + "\n")


def cut_losses(folder: Path, count: str, reached: int) -> None:
    """Remove the lines of what is learned again after a training was stopped: those with a larger `count`.

    Lines that do not have it stay; one that was cut off goes. Raises DataError.
    """
    path = folder / LOSSES
    if not path.exists():
        return
    with written(path):
        lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
        kept = [line for line in lines if _is_before(line, count, reached)]
        if len(kept) < len(lines):
            with draft_of(path) as draft:
                draft.write_text("".join(kept), encoding="utf-8")


def _is_before(line: str, count: str, reached: int) -> bool:
    try:
        values = json.loads(line)
    except ValueError:
        return False
    return bool(line.endswith("\n") and values.get(count, reached) <= reached)
