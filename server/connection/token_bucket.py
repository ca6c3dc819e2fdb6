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

    def take(self, now: float) -> bool:
        """Take one; False when there is none left."""
        left = self._left + (now - self._at) * self.per_s
        if left > self.burst:
            left = self.burst
        enough = left >= 1.0
        self._left, self._at = left - enough, now
        return enough
