"""Pings in a recording: where they pointed, and what the partner did then.

An event says who pinged what; the place follows from the state in which it was said.
"""

import math
from typing import NamedTuple

from movingout.recordings.episode import Episode, Event
from movingout.world.constants import TICK_SECONDS
from movingout.world.ping import OWN_PLACE, HelpPing, said
from movingout.world.state import WorldState

FOLLOWED_WITHIN_S = 5.0
NEAR = 0.45  # arena units between the partner's centre and the pinged place: beside a robot, or at an item


class PingOutcome(NamedTuple):
    """A ping and what followed within FOLLOWED_WITHIN_S."""

    ping: HelpPing
    was_near: bool  # the partner was there already
    came_s: float | None  # after how many seconds it was near or held the item; None for not at all


def ping_of(event: Event, episode: Episode) -> HelpPing:
    """The ping that an event of the kind "ping" tells of. IndexError where there was no such item."""
    states = episode.states
    return said(states[min(max(event.tick - 1, 0), len(states) - 1)], event.seat, event.item)


def ping_outcomes(episode: Episode) -> list[PingOutcome]:
    """Every ping of an episode, in order."""
    return [_outcome(ping_of(event, episode), episode) for event in episode.events if event.kind == "ping"]


def _outcome(ping: HelpPing, episode: Episode) -> PingOutcome:
    states = episode.states[ping.tick - 1 :][: round(FOLLOWED_WITHIN_S / TICK_SECONDS) + 1]
    came = next((number for number, state in enumerate(states) if _answered(ping, state)), None)
    return PingOutcome(ping, came == 0, None if came is None else round(came * TICK_SECONDS, 1))


def _answered(ping: HelpPing, state: WorldState) -> bool:
    """Whether the partner is at the pinged place, at the pinged item, or holds it."""
    partner = 1 - ping.seat
    if ping.item != OWN_PLACE and state.held[partner] == ping.item:
        return True
    x, y = (ping.x, ping.y) if ping.item == OWN_PLACE else state.item_poses[ping.item, :2].tolist()
    return math.dist((x, y), state.robot_poses[partner, :2].tolist()) < NEAR
