"""A learned estimate of progress without any reward: time-contrastive learning (TCL).

An embedding in which moments of an episode that are close in time lie close together, and those that are far apart lie
far apart (Sermanet et al. 2017). The score of a simulated last state s is how far it is from the start of the episode,

    score(s) = |embedding(s) - embedding(s_0)|,

so that nothing has to be known of goals or of what counts as delivered (paper, "Time-Contrastive Learning as a
Reward-Free Progress Estimator").
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from movingout.agents.bass.state_vector import constant, moving
from movingout.agents.bass.value import ValueQuery
from movingout.agents.checkpoint.card import ProgressSpec
from movingout.agents.inference.network import Network
from movingout.agents.observation.seat_observation import start_state
from movingout.maps import MapSpec
from movingout.world.state import Floats


@dataclass(frozen=True, slots=True, eq=False)
class LearnedProgress:
    """A trained embedding, used where agents have a value."""

    spec: ProgressSpec
    network: Network

    def scores_of(self, views: Sequence[ValueQuery], rows: Sequence[Floats], depth: int) -> list[Floats]:
        """Scores (R,) per query, of its moving rows (R, 58): distances from the start. The network is run once."""
        embedded = self._embedded(
            [
                np.concatenate((moving(start_state(spec))[None], each))
                for (spec, _), each in zip(views, rows, strict=True)
            ],
            [spec for spec, _ in views],
        )
        return [np.linalg.norm(each[1:] - each[0], axis=1) for each in embedded]

    def distances(self, the_map: MapSpec, rows: Floats) -> Floats:
        """Distances (T,) of an episode's moving rows (T, 58) from the first of them."""
        (embedded,) = self._embedded([rows], [the_map])
        found: Floats = np.linalg.norm(embedded - embedded[0], axis=1)
        return found

    def _embedded(self, rows: Sequence[Floats], maps: Sequence[MapSpec]) -> list[Floats]:
        constants = [np.tile(constant(the_map), (len(each), 1)) for the_map, each in zip(maps, rows, strict=True)]
        found = self.network(
            state=np.concatenate(rows).astype(np.float32), constant=np.concatenate(constants).astype(np.float32)
        )[0]
        return np.split(found.astype(np.float64), np.cumsum([len(each) for each in rows])[:-1])
