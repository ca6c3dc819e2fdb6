"""Replays a recorded seat, whatever its partner does: `ghost:FILE#red`."""

import numpy as np

from movingout.agents.base import ActionChunk, EpisodeInfo, Observation
from movingout.agents.errors import AgentError
from movingout.maps.spec import SEAT_COLOURS
from movingout.recordings.errors import RecordingError
from movingout.recordings.recorded_seat import read_recorded_seat
from movingout.world.action import to_policy

ROWS = 20  # per answer; the actions are known in advance, so a late answer does no harm
_STILL = np.array([[0.0, 1.0, 0.0, 0.0]])


class ReplayAgent:
    """Repeats the recorded actions tick by tick, then stands still."""

    def __init__(self, recording: str) -> None:
        """`recording` is FILE#blue or FILE#red. Raises AgentError when it cannot be read."""
        try:
            self._ghost = read_recorded_seat(recording)
        except RecordingError as error:
            raise AgentError(str(error)) from error
        self._actions = to_policy(self._ghost.actions)

    def reset(self, episode: EpisodeInfo) -> None:
        """Raises AgentError on another map or in the other seat, where the recording makes no sense."""
        ghost = self._ghost
        if episode.map != ghost.map:
            raise AgentError(f"this ghost was recorded on {ghost.map.name}, not on {episode.map.name}; choose that map")
        if episode.seat != ghost.seat:
            raise AgentError(f"this ghost was recorded in the {SEAT_COLOURS[ghost.seat]} seat; give it that seat")

    def act(self, observation: Observation) -> ActionChunk:
        """(H, 4): the recorded actions from this tick on."""
        start = observation.state.tick
        rows = self._actions[start : start + ROWS]
        return rows.copy() if len(rows) else _STILL.copy()
