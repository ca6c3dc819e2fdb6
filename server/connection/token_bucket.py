"""A token bucket: so many per second, a burst of as many as it holds."""


class TokenBucket:
    """Starts full. Times are seconds of any clock that does not go back."""

    def __init__(self, per_s: float, burst: float, now: float) -> None:
        self.per_s = per_s
        self.burst = burst
        self._left = burst
        self._at = now

    def full(self, now: float) -> bool:
        """Whether nothing has been taken lately."""
        return self._left + (now - self._at) * self.per_s >= self.burst

    def holds(self, now: float, cost: float) -> bool:
        """Whether so much could be taken."""
        return self._left + (now - self._at) * self.per_s >= cost

    def empty(self, now: float) -> None:
        """Take all there is."""
        self._left, self._at = 0.0, now

    def take(self, now: float, cost: float = 1.0) -> bool:
        """Take one, or `cost`; False when there is less."""
        left = self._left + (now - self._at) * self.per_s
        if left > self.burst:
            left = self.burst
        enough = left >= cost
        self._left, self._at = left - cost * enough, now
        return enough
