"""A trained network over options at play: an ONNX graph, no torch."""

from functools import lru_cache

import numpy as np

from movingout.agents.errors import AgentError, CheckpointError
from movingout.agents.inference.network import Network
from movingout.agents.partners.options.features import SIZE, Singles
from movingout.agents.partners.options.option import MOST_OPTIONS

HOTTEST = 5.0


class TrainedScores:
    """The scores of options by a network that takes `options` and `offered`."""

    def __init__(self, data: bytes) -> None:
        """Raises CheckpointError for a graph of another shape."""
        self._network = Network(data)
        shapes = self._network.input_shapes
        found = {name: shape[1:] for name, shape in shapes.items()}
        wanted = {"options": [MOST_OPTIONS, SIZE], "offered": [MOST_OPTIONS]}
        if found != wanted:
            raise CheckpointError(
                f"the network takes {found}, not {wanted}: it is of another version, so train it again"
            )

    def __call__(self, features: Singles) -> Singles:
        """(K,) for features (K, SIZE)."""
        count = len(features)
        options = np.zeros((1, MOST_OPTIONS, SIZE), np.float32)
        offered = np.zeros((1, MOST_OPTIONS), np.float32)
        options[0, :count], offered[0, :count] = features, 1.0
        scores: Singles = self._network(options=options, offered=offered)[0][0, :count]
        return scores


@lru_cache(maxsize=16)
def shared_scores(data: bytes) -> TrainedScores:
    """One network for all agents of a process that use it."""
    return TrainedScores(data)


def checked_temperature(temperature: object) -> float:
    """The option `temperature`. Raises AgentError."""
    if isinstance(temperature, bool) or not isinstance(temperature, int | float) or not 0.0 <= temperature <= HOTTEST:
        raise AgentError(f"temperature is a number from 0 (the best option) to {HOTTEST:g}, not {temperature}")
    return float(temperature)
