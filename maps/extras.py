"""Other packages: what needs which extra and the command that installs it, and what installed ones add to this one."""

import contextlib
import importlib.metadata
import shlex
import sys
from collections.abc import Iterator, Mapping
from functools import lru_cache
from importlib.metadata import EntryPoint
from pathlib import Path

from movingout.maps.errors import MovingOutError

DISTRIBUTION = "moving-out-live"
AGENTS, FAMILIES, METRICS = "movingout.agents", "movingout.families", "movingout.metrics"  # groups of entry points


_ROOT = Path(__file__).resolve().parents[1]  # of a checkout, or the installed package


def install_command(extra: str) -> str:
    """What installs an extra, wherever it is called: from a checkout in the versions that are pinned there."""
    pins, python = _ROOT / "constraints.txt", shlex.quote(sys.executable or "python3")
    if (_ROOT / "pyproject.toml").is_file() and pins.is_file():
        return f"{python} -m pip install -c {shlex.quote(str(pins))} -e {shlex.quote(f'{_ROOT}[{extra}]')}"
    return f"{python} -m pip install '{DISTRIBUTION}[{extra}]'"


class MissingExtraError(MovingOutError):
    """Something was asked for that needs an extra which is not installed."""

    def __init__(self, extra: str, what: str) -> None:
        """`what` is the subject of the sentence: "training", "the 3D viewer"."""
        super().__init__(f"{what} needs the extra `{extra}`; install it with: {install_command(extra)}")


@contextlib.contextmanager
def needs_extra(extra: str, what: str) -> Iterator[None]:
    """Imports of optional libraries stand in this block: MissingExtraError instead of ImportError.

    A missing module of our own stays the error that it is.
    """
    try:
        yield
    except ImportError as error:
        if (error.name or "").partition(".")[0] == "movingout":
            raise
        raise MissingExtraError(extra, what) from error


@lru_cache(maxsize=8)
def installed(group: str) -> Mapping[str, EntryPoint]:
    """The entry points of a group by name, in order; nothing is imported. Of two with one name the first counts."""
    found: dict[str, EntryPoint] = {}
    for entry in importlib.metadata.entry_points(group=group):
        found.setdefault(entry.name, entry)
    return dict(sorted(found.items()))


def package_of(entry: EntryPoint) -> str:
    """The package that an entry point belongs to, with its version."""
    return f"{entry.dist.name} {entry.dist.version}" if entry.dist is not None else entry.module
