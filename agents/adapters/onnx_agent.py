"""An ONNX file in a seat: `onnx:path=policy.onnx,layout=map-v1`. It is checked like the file of a checkpoint.

A recurrent policy carries its memory in further inputs and outputs: `(observation, h, c) -> (action, h', c')`.
"""

import math
from pathlib import Path

import numpy as np
import numpy.typing as npt

from movingout.agents.adapters.chunk_player import Singles, VectorPlayer
from movingout.agents.adapters.layout_choice import LAYOUT_KEY, chosen_layout
from movingout.agents.adapters.policy_file import existing
from movingout.agents.checkpoint.card import MAX_FILE_BYTES
from movingout.agents.checkpoint.checkpoint import named_instead
from movingout.agents.checkpoint.onnx_interface import NETWORK_KEY
from movingout.agents.checkpoint.onnx_validation import check_onnx
from movingout.agents.errors import AgentError, CheckpointError
from movingout.agents.inference.network import Network

MAX_MEMORY = 1 << 20  # numbers
Shape = list[int | str | None]


class OnnxAgent(VectorPlayer):
    """The first input is (batch, D) or (batch, To, D), the first output (batch, 4) or (batch, H, 4).

    Each further input is memory: zeros when an episode starts, then what the output at its place said in the last
    decision.
    """

    def __init__(
        self, path: str, layout: str = "", execute: int = 0, grasp: str = "toggle", headings: str = ""
    ) -> None:
        """`layout` may be left out where the file says it (metadata `movingout.layout`) or its size does.

        Raises AgentError: no such file, operators that are not allowed, wrong sizes.
        """
        if sentence := named_instead(Path(path).expanduser()):
            raise AgentError(sentence)
        file = existing("onnx", path)
        if file.stat().st_size > MAX_FILE_BYTES:
            raise AgentError(f"{file} is larger than {MAX_FILE_BYTES >> 20} MB")
        self._network = _checked_network(file)
        if not self._network.input_shapes:
            raise AgentError("the graph takes nothing; its first input is to be the observation")
        (self._input, shape), *memory = self._network.input_shapes.items()
        self._flat = len(shape) == 2
        size, steps = _sizes(self._input, shape, recurrent=bool(memory))
        self._blank = {name: np.zeros(_memory_shape(name, of), dtype=np.float32) for name, of in memory}
        self._memory = self._blank
        named = chosen_layout(layout, size, self._network.metadata.get(LAYOUT_KEY, ""))
        super().__init__(named, steps, execute, grasp, headings=headings)
        self._try(self._infer)
        _check_memory(self._blank, self._memory)
        self._memory = self._blank

    def _start(self) -> None:
        super()._start()
        self._memory = self._blank

    def _infer(self, seen: Singles) -> npt.ArrayLike:
        answer: npt.NDArray[np.float32]
        answer, *after = self._network(**{self._input: seen if self._flat else seen[None]}, **self._memory)
        self._memory = dict(zip(self._blank, after, strict=False))
        return answer


def _checked_network(file: Path) -> Network:
    """Raises AgentError, with the name of the file, for one that is refused."""
    data = file.read_bytes()
    try:
        check_onnx(data)
        network = Network(data)
    except CheckpointError as error:
        raise AgentError(f"{file}: {error}") from error
    if NETWORK_KEY in network.metadata:
        raise AgentError(
            f"{file} is a network of a trained agent without its card.json; put the whole folder of the agent into "
            "data/models and name the agent by its id"
        )
    return network


def _sizes(name: str, shape: Shape, recurrent: bool) -> tuple[int, int]:
    """The numbers of one observation, and how many observations the input takes. Raises AgentError."""
    if len(shape) not in (2, 3):
        raise AgentError(f"the input {name} has shape {shape}; it is to be (batch, D), or (batch, To, D)")
    if isinstance(shape[0], int) and shape[0] > 2:  # one robot is asked alone, as a batch of one or two
        raise AgentError(
            f"the input {name} has shape {shape}, with a batch of {shape[0]}: a robot decides alone, so export it with "
            "a batch of 1, or leave the batch open"
        )
    size, steps = shape[-1], 1 if len(shape) == 2 else shape[1]
    if recurrent and not isinstance(steps, int):
        steps = 1  # any number of steps: one at a time, the memory has the others
    if not isinstance(size, int) or not isinstance(steps, int):
        raise AgentError(f"the input {name} has shape {shape}; only the batch may be left open")
    return size, steps


def _memory_shape(name: str, shape: Shape) -> list[int]:
    """The shape of a memory for one robot: what is left open is the batch. Raises AgentError when it is too large."""
    of_one = [length if isinstance(length, int) else 1 for length in shape]
    if math.prod(of_one) > MAX_MEMORY:
        raise AgentError(f"the input {name} has shape {shape}; a memory may hold {MAX_MEMORY} numbers")
    return of_one


def _check_memory(before: dict[str, Singles], after: dict[str, Singles]) -> None:
    """Raises AgentError when the outputs after the first do not give the memory back."""
    forms = [(list(np.shape(memory)), np.asarray(memory).dtype) for memory in before.values()]
    given = [(list(np.shape(memory)), np.asarray(memory).dtype) for memory in after.values()]
    if forms != given:
        shapes = ", ".join(f"{name} {list(memory.shape)}" for name, memory in before.items())
        raise AgentError(
            f"the graph takes {shapes} beside the observation; a recurrent graph gives such a memory back after the "
            f"action, in the same order and shape; this one gives {[shape for shape, _ in given] or 'nothing'}"
        )
