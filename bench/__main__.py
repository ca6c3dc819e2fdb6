"""`python -m bench [NAME ...]`, `python -m bench NAME --option ...`: print the machine, then run benchmarks.

Without a name, those in MINUTES run. The others train, or need trained agents and data; `--help` lists the options of
each.
"""

import importlib
import importlib.metadata
import inspect
import itertools
import os
import platform
import sys
from pathlib import Path

from movingout.maps.suggestion import known_names

_FOLDER = Path(__file__).parent
MINUTES: dict[str, tuple[str, ...]] = {
    **dict.fromkeys(("world", "recordings", "server", "processes", "study", "browser", "scripted", "matches"), ()),
    "agents": (),
    "answers": (),
    "attacks": ("--seconds", "5"),
    "soak": ("--minutes", "5"),
    "crowd": ("--participants", "60"),
}
"""What `make bench` runs, with which options: about 17 minutes up to `matches`, then about as long again."""


def main(words: list[str]) -> int:
    """Return the exit code: 0, or 2 for an unknown benchmark or for options without a benchmark that takes them."""
    known = sorted(path.stem for path in _FOLDER.glob("*.py") if not path.stem.startswith("_"))
    names = list(itertools.takewhile(lambda word: not word.startswith("-"), words))
    options = words[len(names) :]
    for name in names:
        if name not in known:
            print(f"unknown benchmark {name!r}; {known_names(name, known)}", file=sys.stderr)
            return 2
    if options and (len(names) != 1 or not _takes_options(names[0])):
        print(f"{options[0]}: put options after the one benchmark they are for, if it takes any", file=sys.stderr)
        return 2
    print(machine())
    for name, chosen in dict.fromkeys(names, tuple(options)).items() if names else MINUTES.items():
        run = importlib.import_module(f"bench.{name}").main
        run([*chosen]) if _takes_options(name) else run()
    return 0


def _takes_options(name: str) -> bool:
    return bool(inspect.signature(importlib.import_module(f"bench.{name}").main).parameters)


def machine() -> str:
    """One line with the processor, the load, the system and the versions that matter."""
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
