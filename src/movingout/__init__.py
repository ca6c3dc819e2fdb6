"""Moving Out Live: people and AI agents carry things together in a 2D physical world.

What most programs need is offered here; each name is imported when it is first used, so that `import movingout` costs
nothing:

    from movingout import World, load_map

    world = World(load_map("HandOff"))
    world.step([[1.0, 0.0, 0], [0.0, 0.0, 0]])  # distance, heading [rad], grasp toggle of blue and of red

Everything else is in the packages `maps`, `world`, `recordings`, `agents`, `matches`, `study` and `server`. A package
imports only those before it.
"""

import importlib
import importlib.util
import os
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable
    from importlib.machinery import ModuleSpec
    from importlib.metadata import version
    from types import ModuleType

    from movingout.agents.catalogue import load_agent as load_agent
    from movingout.agents.conformance import check_agent as check_agent
    from movingout.maps import MovingOutError as MovingOutError
    from movingout.maps import load_map as load_map
    from movingout.matches import play as play
    from movingout.matches import run_grid as run_grid
    from movingout.recordings import read_episode as read_episode
    from movingout.world import World as World

    __version__: str = version("moving-out-live")

# From 1.29 on, onnxruntime reports to its makers which networks run, under an identifier that it keeps in ~/.cache. It
# reads this variable when it is imported. Set here, it also holds for agents of one's own that import onnxruntime.
os.environ.setdefault("ORT_DISABLE_TELEMETRY", "1")

__all__ = [
    "MovingOutError",
    "World",
    "__version__",
    "check_agent",
    "load_agent",
    "load_map",
    "play",
    "read_episode",
    "run_grid",
]

_HOMES = {
    "MovingOutError": "movingout.maps",
    "World": "movingout.world",
    "check_agent": "movingout.agents.conformance",
    "load_agent": "movingout.agents.catalogue",
    "load_map": "movingout.maps",
    "play": "movingout.matches",
    "read_episode": "movingout.recordings",
    "run_grid": "movingout.matches",
}


def __getattr__(name: str) -> object:
    """Import a public name when it is first asked for (PEP 562)."""
    if name == "__version__":
        value: object = importlib.import_module("importlib.metadata").version("moving-out-live")
    elif name in _HOMES:
        value = getattr(importlib.import_module(_HOMES[name]), name)
    else:
        raise AttributeError(f"module 'movingout' has no attribute {name!r}; it offers {', '.join(__all__)}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


class _GymnasiumFinder:
    """Waits for `import gymnasium`, and makes `gymnasium.make("MovingOut-v1")` known to it.

    It stays: who only asks whether Gymnasium is there, as TorchRL does, finds it without importing it.
    """

    def find_spec(self, name: str, path: object = None, target: object = None) -> "ModuleSpec | None":
        """The spec of gymnasium, whose loader also registers our environment; None for all else."""
        if name != "gymnasium" or self not in sys.meta_path:
            return None
        others = sys.meta_path[sys.meta_path.index(self) + 1 :]
        found = (finder.find_spec(name, path, target) for finder in others if hasattr(finder, "find_spec"))  # type: ignore[arg-type]
        spec = next((spec for spec in found if spec is not None), None)
        if spec is not None and spec.loader is not None:
            spec.loader.exec_module = _registering(spec.loader.exec_module)  # type: ignore[method-assign, assignment]
        return spec


def _registering(execute: "Callable[[ModuleType], None]") -> "Callable[[ModuleType], None]":
    def exec_module(module: "ModuleType") -> None:
        execute(module)
        importlib.import_module("movingout.agents.environment")

    return exec_module


if "gymnasium" in sys.modules:
    importlib.import_module("movingout.agents.environment")
else:
    sys.meta_path.insert(0, _GymnasiumFinder())
