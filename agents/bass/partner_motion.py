"""BASS whose guesses of the partner go on from what the partner does now, as its motion shows."""

import math

import numpy as np

from movingout.agents.bass.engine_agent import EngineBassAgent
from movingout.agents.inference.network import Singles
from movingout.maps import MapSpec
from movingout.world.constants import DRIVE_SPEED, SLOW_FACTOR, TICK_SECONDS, TURN_FIRST_ANGLE
from movingout.world.state import WorldState

STANDS = 0.05  # of full speed
KEPT = 0.6  # share of the present action in a guess, per tick ahead: people turn


class MotionBassAgent(EngineBassAgent):
    """Guesses that the partner goes on as it moves, and less and less so what the policy would do in its place."""

    def guesses(self, partner: Singles, state: WorldState) -> Singles:
        seen = command_seen(self.episode.map, state, 1 - self.episode.seat)
        if seen is None:
            return partner
        share = np.float32(KEPT) ** np.arange(partner.shape[1], dtype=np.float32)[None, :, None]
        guessed = partner.copy()
        guessed[..., :3] = share * seen + (1 - share) * partner[..., :3]
        return guessed


def command_seen(the_map: MapSpec, state: WorldState, seat: int) -> Singles | None:
    """Distance, cos and sin of the heading (3,) that drive a robot as it moves: `world.drive` the other way round.

    None when both hold the same item: it moves by the mean of two commands.
    """
    item = int(state.held[seat])
    if item >= 0 and item == state.held[1 - seat]:
        return None
    vx, vy, turning = state.robot_velocities[seat]
    distance, heading = math.hypot(vx, vy) / DRIVE_SPEED, math.atan2(-vx, vy)
    if distance < STANDS:
        return np.array([0.0, 1.0, 0.0], dtype=np.float32)
    size = the_map.items[item].size if item >= 0 else "small"  # an empty hand drives like one with a small item
    angle = float(state.robot_poses[seat, 2]) - float(turning) * TICK_SECONDS  # when the command was given
    if item >= 0 and math.cos(heading - angle) < 0.0:  # a loaded robot that moves backwards is told so
        distance, heading = -distance, heading + math.pi
    turns_first = size == "small" and math.cos(heading - angle) <= math.cos(TURN_FIRST_ANGLE)
    if turns_first or size == "middle":
        distance /= SLOW_FACTOR
    return np.array([np.clip(distance, -1.0, 1.0), math.cos(heading), math.sin(heading)], dtype=np.float32)
