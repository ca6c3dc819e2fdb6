"""A LeRobot policy in a seat: `lerobot:path=outputs/train/…/pretrained_model`; its weights are safetensors."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from movingout.agents.adapters.chunk_player import ROW, ChunkPlayer
from movingout.agents.adapters.layout_choice import chosen_layout
from movingout.agents.adapters.policy_file import MissingPackageError, existing
from movingout.agents.base import Observation
from movingout.agents.errors import AgentError
from movingout.world.raster import pixels

try:
    import torch
    from lerobot.configs.policies import PreTrainedConfig
    from lerobot.policies.factory import get_policy_class, make_pre_post_processors

    from movingout.agents.adapters.torch_state import TorchState
except ImportError as error:
    raise MissingPackageError("lerobot", "lerobot", "lerobot") from error

STATE, ENVIRONMENT, IMAGE = "observation.state", "observation.environment_state", "observation.images.view"


class LeRobotAgent(ChunkPlayer):
    """Sees what `recordings export --to lerobot` writes. It is asked every tick and keeps its own queue of actions."""

    def __init__(self, path: str, layout: str = "", grasp: str = "toggle", headings: str = "") -> None:
        """`layout` may be left out, since its size says it.

        Raises AgentError: no such folder, other features than the export's, a policy that this lerobot cannot load.
        """
        super().__init__(0, grasp, headings)
        folder = existing("lerobot", path, folder=True)
        sizes, self._side = _inputs(folder)
        self.layout = chosen_layout(layout, sum(sizes.values()) or None)
        self._sizes = sizes
        self._torch = TorchState()
        with self._torch.in_use():
            self._policy, self._before, self._after = _loaded(folder)

    def _start(self) -> None:
        self._torch.reset(self.episode)
        with self._torch.in_use():
            self._policy.reset()

    def _decide(self, observation: Observation) -> npt.ArrayLike:
        with self._torch.in_use(), torch.inference_mode():
            answer = self._after(self._policy.select_action(self._before(self._frame(observation))))
        rows: npt.ArrayLike = answer.float().cpu().numpy()
        return rows

    def _frame(self, observation: Observation) -> dict[str, Any]:
        """The observation as a frame of the data set, without a batch."""
        numbers = torch.from_numpy(observation.encode(self.layout).astype(np.float32))
        split = torch.split(numbers, list(self._sizes.values()))
        frame: dict[str, Any] = dict(zip(self._sizes, split, strict=True))
        if self._side:
            picture = pixels(self.episode.map, observation.state, observation.seat, self._side)
            frame[IMAGE] = torch.from_numpy(picture).permute(2, 0, 1).float() / 255
        return frame


def _inputs(folder: Path) -> tuple[dict[str, int], int]:
    """The sizes of the two parts of a layout, in their order, and the side of the picture (0: none).

    Raises AgentError for features that our export does not write.
    """
    config = _config(folder)
    inputs, output = config.get("input_features") or {}, (config.get("output_features") or {}).get("action") or {}
    strange = [name for name in inputs if name not in (STATE, ENVIRONMENT, IMAGE)]
    if strange:
        raise AgentError(f"{folder} takes {', '.join(strange)}, which the game does not have; it has {STATE}, ...")
    if output.get("shape") != [4]:
        raise AgentError(f"{folder} answers with actions of shape {output.get('shape')}; {ROW}")
    sizes = {name: int(inputs[name]["shape"][0]) for name in (STATE, ENVIRONMENT) if name in inputs}
    shape = inputs[IMAGE]["shape"] if IMAGE in inputs else [3, 0, 0]
    if shape[1] != shape[2]:
        raise AgentError(f"{folder} takes pictures of {shape[2]} x {shape[1]} pixels; ours are squares")
    return sizes, int(shape[1])


def _config(folder: Path) -> Mapping[str, Any]:
    file = folder / "config.json"
    try:
        config = json.loads(file.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise AgentError(
            f"{folder} is no policy of LeRobot: it has no config.json; name the folder pretrained_model of a checkpoint"
        ) from error
    except ValueError as error:
        raise AgentError(f"{file} is damaged: {error}") from error
    if not isinstance(config, dict) or "type" not in config:
        raise AgentError(f"{file} names no type of policy")
    return config


def _loaded(folder: Path) -> tuple[Any, Any, Any]:
    """The policy on the CPU, and what stands before and after it."""
    try:
        config = PreTrainedConfig.from_pretrained(str(folder))
        config.device = "cpu"
        policy = get_policy_class(config.type).from_pretrained(str(folder), config=config)
        device = {"device_processor": {"device": "cpu"}}
        before, after = make_pre_post_processors(
            config, pretrained_path=str(folder), preprocessor_overrides=device, postprocessor_overrides={}
        )
    except Exception as error:  # whatever lerobot raises for a checkpoint of another version
        raise AgentError(f"lerobot cannot load {folder}: {type(error).__name__}: {error}"[:400]) from error
    return policy.eval(), before, after
