"""Whether handing over in a lane works with this partner: else one carries everything home alone for a while."""

from movingout.agents.scripted.perception import Perception

LEFT_LYING_FOR = 40  # ticks for which nobody comes for what was handed over, or brings anything
CARRIES_ALONE_FOR = 150  # ticks for which it then carries things home itself
_SEEN_LATELY = 10  # ticks between two looks of one wait


class HandoverTrust:
    """What one seat has seen of its partner's handing over in one episode. Always content without an intent."""

    def __init__(self) -> None:
        self._alone_until = -1
        self._lying: dict[int, int] = {}  # by item: tick since when it lies at the handover point
        self._waits_since = self._looked_at = 0

    def lasts(self, tick: int) -> bool:
        """Whether to hand things over."""
        return tick >= self._alone_until

    def is_lost(self, now: Perception) -> None:
        """Carry things home alone from now on for a while."""
        self._alone_until = now.tick + CARRIES_ALONE_FOR

    def nobody_comes(self, now: Perception, handed: list[int]) -> bool:
        """Whether the partner has not come for long for any of the items that were handed over."""
        if now.intent is None:
            return False
        self._lying = {item: self._lying.get(item, now.tick) for item in handed}
        if any(now.intent.is_coming(now.state, item) for item in handed):
            self._lying = dict.fromkeys(handed, now.tick)
        return any(now.tick - since > LEFT_LYING_FOR for since in self._lying.values())

    def nobody_brings(self, now: Perception) -> bool:
        """Whether the partner has brought nothing for long and carries nothing now."""
        if now.intent is None:
            return False
        if now.partner_item >= 0 or now.tick - self._looked_at > _SEEN_LATELY:
            self._waits_since = now.tick
        self._looked_at = now.tick
        return now.tick - self._waits_since > LEFT_LYING_FOR
