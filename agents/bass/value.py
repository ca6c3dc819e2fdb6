"""A learned value of states, so that selection looks beyond the simulated ticks.

The paper scores a candidate by the NFD of its last simulated state, eight ticks ahead at most. Walking to an item,
turning it or letting go of it changes nothing by then, so most choices are between equals. Here the score of a
last state s is the progress made by then plus the progress expected to follow,

    score(s) = progress(s) + discount ** depth * V(s),    progress = (NFD + TCR) / 2,

where V(s) estimates the discounted progress that recorded episodes made from states like s. This is not in the paper;
choosing among samples of a diffusion policy by a value is known from offline reinforcement learning
(Hansen-Estruch et al. 2023).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from movingout.agents.bass.state_vector import states_of
from movingout.agents.checkpoint.card import ValueSpec
from movingout.agents.inference.mirror import FeatureMirror
from movingout.agents.inference.network import Network, Singles
from movingout.maps import MapSpec
from movingout.world.metrics import WEIGHTS, normalized_final_distance
from movingout.world.observation import ITEM_SLOTS, encoder
from movingout.world.scoring import delivered_many
from movingout.world.state import Floats

ValueQuery = tuple[MapSpec, int]
"""The map, and the seat from which its states are valued."""


@dataclass(frozen=True, slots=True, eq=False)
class Value:
    """A trained value network."""

    spec: ValueSpec
    network: Network
    mirror: FeatureMirror | None = None
    """With it a state is worth the mean of what the network says of it and of its mirror image."""

    def scores_of(self, views: Sequence[ValueQuery], rows: Sequence[Floats], depth: int) -> list[Floats]:
        """Scores (R,) per query, of its moving rows (R, 58): progress after `depth` ticks plus discounted value.

        Where the network gives the value of each of its members, so do the scores: (R, members).
        The network is run once for all; rows of the same map and seat are encoded together.
        """
        groups: dict[ValueQuery, list[int]] = {}
        for index, view in enumerate(views):
            groups.setdefault(view, []).append(index)
        order = [index for group in groups.values() for index in group]
        layout = self.spec.layout
        looked = [
            _encoded(*view, np.concatenate([rows[index] for index in group]), layout) for view, group in groups.items()
        ]
        follows = self._of(np.concatenate([seen for seen, _ in looked]).astype(np.float32))
        done = np.concatenate([done for _, done in looked])
        scores = (done[:, None] if follows.ndim == 2 else done) + self.spec.discount**depth * follows
        parts = np.split(scores, np.cumsum([len(rows[index]) for index in order])[:-1])
        found = dict(zip(order, parts, strict=True))
        return [found[index] for index in range(len(views))]

    def _of(self, features: Singles) -> Singles:
        """What follows (R,) or (R, members)."""
        follows: Singles = self.network(features=features)[0]
        if self.mirror is None:
            return follows
        image: Singles = self.network(features=self.mirror.image(features))[0]
        return (follows + image) / np.float32(2.0)


def _encoded(map_spec: MapSpec, seat: int, rows: Floats, layout: str) -> tuple[Floats, Floats]:
    """Features (R, D) of moving rows (R, 58), and the progress made by then (R,)."""
    arrays = states_of(rows, len(map_spec.items))
    features = encoder(map_spec, layout).encode_arrays(*arrays, seat)
    return features, progress(map_spec, arrays[3], delivered_many(map_spec, arrays[3]).astype(np.float64))


def progress(map_spec: MapSpec, item_poses: Floats, delivered: Floats) -> Floats:
    """Mean of NFD and TCR (T,), for item poses (T, N, 3) and delivered flags (T, 7) or (T, N)."""
    weights = np.zeros(ITEM_SLOTS)
    weights[: len(map_spec.items)] = [WEIGHTS[item.size] for item in map_spec.items]
    completion = delivered @ weights[: delivered.shape[1]] / weights.sum()
    mean: Floats = (normalized_final_distance(map_spec, item_poses) + completion) / 2
    return mean
