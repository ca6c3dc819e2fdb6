"""`python -m bench [name ...]`: run the named benchmarks, after naming the machine.

Without a name: those of MINUTES. The others train, or need trained agents and data; each says what it takes.
"""

import importlib
import importlib.metadata
import os
import platform
import sys
from pathlib import Path

_FOLDER = Path(__file__).parent
MINUTES = ("world", "recordings", "server", "study", "browser", "scripted", "matches")
"""What `make bench` runs: about a quarter of an hour altogether."""


def main(names: list[str]) -> int:
    """Exit code 0, or 2 for a name that is no benchmark."""
    known = sorted(path.stem for path in _FOLDER.glob("*.py") if not path.stem.startswith("_"))
    for name in names:
        if name not in known:
            print(f"unknown benchmark {name!r}; known: {', '.join(known)}", file=sys.stderr)
            return 2
    print(machine())
    for name in names or MINUTES:
        importlib.import_module(f"bench.{name}").main()
    return 0


def machine() -> str:
    """One line that names the processor, the system and the versions that matter."""
    versions = ", ".join(f"{name} {importlib.metadata.version(name)}" for name in ("pymunk", "numpy"))
    load = os.getloadavg()[0]
    return (
        f"{_processor()}, {os.cpu_count()} cores (load {load:.1f}), {platform.system()} {platform.machine()}, "
        f"Python {platform.python_version()}, {versions}"
    )


def _processor() -> str:
    cpuinfo = Path("/proc/cpuinfo")
    lines = cpuinfo.read_text().splitlines() if cpuinfo.exists() else []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.processor() or "unknown processor"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
