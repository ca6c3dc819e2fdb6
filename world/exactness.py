"""Whether the installed physics engine gives the official benchmark's numbers to the last bit.

It is known by version and platform: pymunk 6.8.0 to 6.11.1 on x86-64 Linux replay the official trajectories bit for bit
(`tests/world`); other builds round differently, and version 7 changed the engine. `movingout doctor` also simulates.
"""

import importlib.metadata
import platform
import re

OLDEST, NEWEST = "6.8.0", "6.11.1"
_SYSTEM, _MACHINES = "Linux", ("x86_64", "AMD64")


def inexact_engine() -> str | None:
    """One sentence saying why results may differ from the official benchmark; None where they are exact."""
    version = importlib.metadata.version("pymunk")
    if not _numbers(OLDEST) <= _numbers(version) <= _numbers(NEWEST):
        advice = f"install pymunk {NEWEST} for exact results"
        return f"physics are not exact: pymunk {version} is outside {OLDEST} to {NEWEST}; {advice}"
    if platform.system() != _SYSTEM or platform.machine() not in _MACHINES:
        here = f"{platform.system()} {platform.machine()}"
        return f"physics may not be exact: bit equality is known on x86-64 Linux only, and this is {here}"
    return None


def _numbers(version: str) -> tuple[int, ...]:
    """`6.11.1` as (6, 11, 1); what follows the digits of a part is ignored."""
    found = (re.match(r"\d+", part) for part in version.split(".")[:3])
    return tuple(int(match[0]) if match else 0 for match in found)
