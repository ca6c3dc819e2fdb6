"""Pings: "help here", said by one seat at its own place or at an item, and shown to both for two seconds."""

from collections.abc import Iterable
from typing import NamedTuple

from movingout.world.state import WorldState

PING_TICKS = 20  # for which a ping is shown: 2 s
OWN_PLACE = -1  # instead of an item


class HelpPing(NamedTuple):
    """One ping."""

    tick: int  # the first tick that follows it
    seat: int  # who asks: 0 blue, 1 red
    item: int  # index into items, OWN_PLACE for the place of the robot
    x: float  # where that was when it was said, arena units
    y: float


def said(state: WorldState, seat: int, item: int) -> HelpPing:
    """The ping that a seat says in `state`. IndexError where there is no such item."""
    if not OWN_PLACE <= item < len(state.item_poses):
        raise IndexError(f"there is no item {item}")
    x, y, _ = (state.robot_poses[seat] if item == OWN_PLACE else state.item_poses[item]).tolist()
    return HelpPing(state.tick + 1, seat, item, x, y)


def shown(pings: Iterable[HelpPing], tick: int) -> tuple[HelpPing, ...]:
    """Those that are shown after `tick` ticks."""
    return tuple(ping for ping in pings if ping.tick <= tick + 1 and tick < ping.tick + PING_TICKS)
