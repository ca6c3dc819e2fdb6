"""What will come of a state: a learned value, so that selection sees farther than the simulated ticks.

The paper scores a candidate by the NFD of its last simulated state, eight ticks ahead at most. Whoever walks to an
item, turns it or lets go of it has nothing to show by then, so most choices are between equals. Here the score of a
last state s is what has been done by then and what is expected to follow,

    score(s) = progress(s) + discount ** depth * V(s),    progress = (NFD + TCR) / 2,

where V(s) is the discounted progress that recorded episodes went on to make from states like s. Not in the paper;
sampling from a diffusion policy and taking what a value prefers is known from offline reinforcement learning
(Hansen-Estruch et al. 2023).
"""

from dataclasses import dataclass

import numpy as np

from agents.bass.state_vector import states_of
from agents.checkpoint import ValueSpec
from agents.features import feature_encoder
from agents.serving import Network
from maps import MapSpec
from world.metrics import WEIGHTS, normalized_final_distance
from world.observation import ITEM_SLOTS
from world.state import Floats

LAYOUT = "aware-v1"  # what the network sees, from the seat that chooses


@dataclass(frozen=True, slots=True, eq=False)
class Value:
    """A trained value network."""

    spec: ValueSpec
    network: Network

    def outlook(self, map_spec: MapSpec, seat: int, rows: Floats, depth: int) -> Floats:
        """(R,) what is done in states given as moving rows (R, 58) and what will follow, for states `depth` ahead."""
        encoder = feature_encoder(map_spec, LAYOUT)
        arrays = states_of(rows, len(map_spec.items))
        features = encoder.encode_arrays(*arrays, seat)
        follows = self.network(features=features.astype(np.float32))[0]
        done = progress(map_spec, arrays[3], encoder.delivered(features))
        scores: Floats = done + self.spec.discount**depth * follows
        return scores


def progress(map_spec: MapSpec, item_poses: Floats, delivered: Floats) -> Floats:
    """(T,) the mean of NFD and TCR, for item poses (T, N, 3) and flags (T, 7) or (T, N) of delivered items."""
    weights = np.zeros(ITEM_SLOTS)
    weights[: len(map_spec.items)] = [WEIGHTS[item.size] for item in map_spec.items]
    completion = delivered @ weights[: delivered.shape[1]] / weights.sum()
    mean: Floats = (normalized_final_distance(map_spec, item_poses) + completion) / 2
    return mean
