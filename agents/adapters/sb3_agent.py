"""A model of Stable-Baselines3 in a seat: `sb3:path=ppo.zip`. The file contains pickles: load only your own."""

import json
import math
import pickle
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from movingout.agents.adapters.action_box import action_box
from movingout.agents.adapters.chunk_player import ROW, Singles, VectorPlayer
from movingout.agents.adapters.layout_choice import chosen_layout
from movingout.agents.adapters.policy_file import MissingPackageError, existing
from movingout.agents.agent_options import yes_or_no
from movingout.agents.errors import AgentError
from movingout.world.observation import PICTURE_SHAPE

try:
    import stable_baselines3

    from movingout.agents.adapters.torch_state import TorchState
except ImportError as error:
    raise MissingPackageError("sb3", "stable-baselines3", "stable-baselines3") from error

_OWN = ("PPO", "A2C", "SAC", "TD3", "DDPG")
_CONTRIB = ("RecurrentPPO", "TQC", "TRPO")  # of sb3-contrib
_MARKS = {"clip_range": "PPO", "line_search_shrinking_factor": "TRPO"}  # settings that one actor-critic alone has


class Sb3Agent(VectorPlayer):
    """A model that was trained in `MovingOut-v1`, or in `MovingOutEnv` through SuperSuit."""

    def __init__(
        self,
        path: str,
        layout: str = "",
        algorithm: str = "",
        normalize: str = "",
        deterministic: bool = True,
        grasp: str = "toggle",
        rescaled: bool | str = "",
        headings: str = "",
    ) -> None:
        """`layout` may be left out, since its size says it; `algorithm` where the file does.

        `normalize` is the file of a VecNormalize; `rescaled`, yes or no, whether the range of the actions is one of
        `RescaleAction`, by default where all go from -1 to 1. Raises AgentError: no such file, an algorithm that
        cannot play, wrong sizes or ranges, a missing package.
        """
        file = existing("sb3", path)
        self._torch = TorchState()
        with self._torch.in_use():
            self._model = _loaded(file, _class_of(file, algorithm))
        size = _size(self._model)
        is_rescaled = None if rescaled == "" else yes_or_no("rescaled", rescaled)
        self._box = action_box(self._model.action_space.low, self._model.action_space.high, is_rescaled)
        self._shows = len(self._model.observation_space.shape) == 3
        self._scale = _normalizer(normalize, size)
        self._deterministic = deterministic
        self._state: Any = None
        super().__init__(chosen_layout(layout, size), 1, 0, grasp, headings=headings)
        self._try(self._infer)

    def _start(self) -> None:
        super()._start()
        self._state = None
        self._torch.reset(self.episode)  # for actions that are not deterministic

    def _infer(self, seen: Singles) -> npt.ArrayLike:
        observation = seen.reshape(-1, *PICTURE_SHAPE).astype(np.uint8) if self._shows else seen
        if self._scale is not None:
            observation = self._scale.normalize_obs(observation)
        begins = np.array([self._state is None])
        with self._torch.in_use():
            action, self._state = self._model.predict(observation, self._state, begins, self._deterministic)
        return self._box.ours(action)


def _class_of(file: Path, named: str) -> Any:
    """The algorithm's class. Raises AgentError for one that is unknown or not installed."""
    known = {name.lower(): name for name in (*_OWN, *_CONTRIB)}
    name = known.get((named or _named_by(file)).lower())
    if name is None:
        raise AgentError(f"{file} is a model of {named or 'an unknown algorithm'}; known: {', '.join(known.values())}")
    if name in _OWN:
        return getattr(stable_baselines3, name)
    try:
        import sb3_contrib
    except ImportError as error:
        raise MissingPackageError("sb3", "sb3-contrib", "sb3-contrib") from error
    return getattr(sb3_contrib, name)


def _named_by(file: Path) -> str:
    """The algorithm, which the archive says only by the module of its policy and by its settings."""
    try:
        with zipfile.ZipFile(file) as archive:
            data = json.loads(archive.read("data"))
    except (OSError, zipfile.BadZipFile, KeyError, ValueError) as error:
        raise AgentError(f"{file} is no model of Stable-Baselines3; write it with model.save(…)") from error
    module = str(data.get("policy_class", {}).get("__module__", ""))
    family = module.rpartition(".")[0].rpartition(".")[2]
    if family == "dqn":
        raise AgentError(f"{file} is a model of DQN, which chooses among numbered actions; {ROW}")
    if "recurrent" in module or "recurrent" in family:
        return "RecurrentPPO"
    if family in ("sac", "td3", "tqc"):
        return family
    return next((name for key, name in _MARKS.items() if key in data), "A2C")


def _loaded(file: Path, kind: Any) -> Any:
    try:
        return kind.load(file, device="cpu", seed=None)  # its own would seed random, NumPy and torch
    except Exception as error:  # whatever a pickle of another version does
        raise AgentError(f"{kind.__name__} cannot load {file}: {type(error).__name__}: {error}"[:400]) from error


def _size(model: Any) -> int:
    """D. Raises AgentError for spaces that are not those of our environments."""
    actions, seen = model.action_space, model.observation_space.shape
    if actions.shape != (4,) or not hasattr(actions, "low"):  # MultiDiscrete has none
        raise AgentError(f"the model's actions are {actions}; {ROW}")
    if seen in (PICTURE_SHAPE, (3, *PICTURE_SHAPE[:2])):  # the library puts the colours first
        return math.prod(seen)
    if seen is None or len(seen) != 1:
        height, width, _ = PICTURE_SHAPE
        wanted = f"a layout is one row of numbers, or a picture of {height} x {width} pixels"
        raise AgentError(f"the model's observations have shape {seen}; {wanted}")
    return int(seen[0])


def _normalizer(path: str, size: int) -> Any:
    if not path:
        return None
    from stable_baselines3.common.save_util import load_from_pkl
    from stable_baselines3.common.vec_env import VecNormalize

    try:
        found = load_from_pkl(existing("sb3", path))
    except (pickle.UnpicklingError, EOFError, AttributeError, ImportError):
        found = None
    if not isinstance(found, VecNormalize) or math.prod(found.observation_space.shape or ()) != size:
        raise AgentError(f"{path} is not the VecNormalize of observations of {size} numbers")
    return found
