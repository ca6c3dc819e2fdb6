"""Versions of the software that made a recording: equal floats need the same engine."""

import platform
from collections.abc import Mapping
from functools import cache
from importlib.metadata import PackageNotFoundError, version


@cache
def versions() -> dict[str, str]:
    """This installation, as written into each recording."""
    return {
        "movingout": _version("moving-out-live"),
        "pymunk": _version("pymunk"),
        "numpy": _version("numpy"),
        "python": platform.python_version(),
        "machine": platform.machine(),
        "system": platform.system(),
    }


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "unknown"


def why_not_exact(recorded: Mapping[str, str]) -> str:
    """Why equal floats are not guaranteed for a recording made elsewhere; empty when they are."""
    here = versions()
    differing = [
        f"{name} {recorded.get(name, 'unknown')} (here {here[name]})"
        for name in ("pymunk", "machine", "system")
        if recorded.get(name, here[name] if name != "pymunk" else "") != here[name]
    ]
    return f"recorded with {', '.join(differing)}: equal bits are not promised" if differing else ""
