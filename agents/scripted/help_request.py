"""What the partner has asked for by a ping: help with an item, or to come near; and for how long that is tried."""

import math

from movingout.agents.scripted.perception import Perception
from movingout.world.ping import OWN_PLACE, HelpPing

ITEM_FOR = 150  # ticks for which help with an item is tried, what is carried just now included
PLACE_FOR = 60  # ticks for going to a place and waiting there
_AT_THE_PLACE = 0.6  # units from the pinged place within which a heavy item is what help is needed with


class HelpRequest:
    """The partner's newest request. Without a ping none is ever open."""

    def __init__(self) -> None:
        self.item = OWN_PLACE  # to help with; OWN_PLACE to come to `place`
        self.place = (0.0, 0.0)
        self.until = -1  # the tick at which it is given up
        self._heard = -1  # the tick of the newest ping

    def hear(self, now: Perception, pings: tuple[HelpPing, ...]) -> bool:
        """Take over the partner's newest ping; whether there is a new one."""
        new = [ping for ping in pings if ping.seat != now.seat and ping.tick > self._heard]
        if not new:
            return False
        ping = new[-1]
        self._heard, self.place = ping.tick, (ping.x, ping.y)
        self.item = _meant(now, ping)
        self.until = now.tick + (PLACE_FOR if self.item == OWN_PLACE else ITEM_FOR)
        return True

    def is_open(self, now: Perception) -> bool:
        """Whether something is to be done about it; it is over when the item is delivered."""
        if self.item >= 0 and (now.delivered[self.item] or self._is_in_small_hands(now)):
            self.drop()
        return now.tick < self.until

    def drop(self) -> None:
        """It cannot be fulfilled."""
        self.until = -1

    def _is_in_small_hands(self, now: Perception) -> bool:
        """Whether the partner has taken the item itself and needs nobody."""
        return self.item == now.partner_item and not now.is_heavy(self.item)


def _meant(now: Perception, ping: HelpPing) -> int:
    """The item that help is needed with, OWN_PLACE where none is to be seen."""
    if ping.item >= 0:
        is_theirs = ping.item == now.partner_item and not now.is_heavy(ping.item)
        return OWN_PLACE if is_theirs else ping.item
    if now.partner_item >= 0 and now.is_heavy(now.partner_item):
        return now.partner_item
    heavy = [item for item in now.waiting if now.is_heavy(item)]
    gaps = {item: math.dist(now.item_pose(item)[:2].tolist(), (ping.x, ping.y)) for item in heavy}
    near = [item for item in heavy if gaps[item] < _AT_THE_PLACE]
    return min(near, key=lambda item: (gaps[item], item), default=OWN_PLACE)
