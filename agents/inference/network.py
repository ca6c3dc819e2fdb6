"""Trained networks at play: ONNX graphs on one thread of onnxruntime, or on a GPU. No torch."""

from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt
import onnxruntime

from movingout.agents.base import THREADS
from movingout.agents.checkpoint.policy_spec import ACTION_WIDTH, PolicySpec
from movingout.agents.errors import CheckpointError
from movingout.agents.inference.device import providers

Singles = npt.NDArray[np.float32]


class Network:
    """An ONNX graph that runs on one thread, or on a GPU (agents.inference.device)."""

    def __init__(self, data: bytes) -> None:
        """Raises CheckpointError."""
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = THREADS
        options.inter_op_num_threads = THREADS
        options.log_severity_level = 3
        options.enable_mem_reuse = False  # saves next to nothing; to plan it takes a minute for 36 steps of a U-Net
        where = providers()
        try:
            self._session = onnxruntime.InferenceSession(data, options, providers=where)
        except Exception as error:  # onnxruntime has no common base of its own errors
            raise CheckpointError(f"onnxruntime cannot load this network: {error}"[:300]) from error
        self.input_shapes = {argument.name: list(argument.shape) for argument in self._session.get_inputs()}
        self.metadata: dict[str, str] = dict(self._session.get_modelmeta().custom_metadata_map)
        self._takes_one = any(shape[:1] == [1] for shape in self.input_shapes.values())

    def __call__(self, **inputs: Singles) -> list[Any]:
        """The outputs for named inputs, batch first; inputs that the graph does not have are ignored.

        onnxruntime sums a batch of one in another order than the same row in a larger batch. A single row is therefore
        run twice in one batch, so that an agent decides the same alone and beside others, unless the graph
        takes no more than one.
        """
        asked = {name: inputs[name] for name in self.input_shapes}
        if self._takes_one or any(len(rows) != 1 for rows in asked.values()):
            return list(self._session.run(None, asked))
        twice = {name: np.concatenate((rows, rows)) for name, rows in asked.items()}
        return [rows[:1] for rows in self._session.run(None, twice)]


class PolicyNetwork:
    """A policy's network: observations in, chunks out."""

    def __init__(self, spec: PolicySpec, data: bytes) -> None:
        """Raises CheckpointError when the graph does not match the spec."""
        self.spec = spec
        self._network = Network(data)
        check_size(self._network, "observation", spec.features, spec.layout)
        self.noise_rows = _noise_rows(self._network)
        history = np.zeros((1, spec.obs_horizon, spec.features), dtype=np.float32)
        try:
            chunks = self.sample(history, np.random.default_rng(0))
        except Exception as error:  # a foreign graph may fail in any way
            said = " ".join(str(error).split())
            raise CheckpointError(f"the network does not take what its card says: {said}"[:300]) from error
        if chunks.shape != (1, spec.horizon, ACTION_WIDTH):
            raise CheckpointError(f"the network answers with shape {chunks.shape}, not (1, {spec.horizon}, 5)")
        if not np.isfinite(chunks).all():
            raise CheckpointError("the network answers with numbers that are not finite")

    def sample(self, history: Singles, random: np.random.Generator) -> Singles:
        """Chunks (B, H, 5) for observations (B, To, D), each from its own noise."""
        return self.run(history, self.noise(len(history), random))

    def noise(self, count: int, random: np.random.Generator) -> Singles:
        """(count, rows, H, 5) for `run`."""
        spec = self.spec
        shape = (count, max(self.noise_rows, 1), spec.horizon, ACTION_WIDTH)
        drawn: Singles = random.standard_normal(shape, dtype=np.float32)
        return drawn

    def run(self, history: Singles, noise: Singles) -> Singles:
        """Chunks (B, H, 5) for observations (B, To, D) and noise (B, rows, H, 5); rows do not affect each other."""
        chunks: Singles = self._network(observation=history, noise=noise)[0]
        return chunks


def check_size(network: Network, name: str, size: int, layout: str) -> None:
    """Raises CheckpointError for an input of another length than `size`, that of the layout and what is behind it.

    A network of an older version of the layout is one, as is one of another agent.
    """
    length = network.input_shapes.get(name, [None])[-1]
    if isinstance(length, int) and length != size:
        raise CheckpointError(
            f"the network takes {length} numbers, and its card says {layout}, which gives {size} here: it is "
            "another agent's, or of another version of this layout; train it again"
        )


def _noise_rows(network: Network) -> int:
    """R of the graph's input `noise` (B, R, H, 5); 0 where it has none. Raises CheckpointError when R is not fixed."""
    shape = network.input_shapes.get("noise")
    if shape is None:
        return 0
    if len(shape) != 4 or not isinstance(shape[1], int):
        raise CheckpointError(f"the network's input noise has shape {shape}, not (batch, rows, horizon, 5)")
    return shape[1]


@lru_cache(maxsize=4)
def shared_policy_network(spec: PolicySpec, data: bytes) -> PolicyNetwork:
    """One network for all agents of a process that use it."""
    return PolicyNetwork(spec, data)


@lru_cache(maxsize=8)
def shared_network(data: bytes) -> Network:
    """Likewise, for simulators and values."""
    return Network(data)
