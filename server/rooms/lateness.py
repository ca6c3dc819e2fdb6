"""How late ticks are: a histogram fine enough for percentiles, small enough to keep forever."""

BUCKET_MS = 0.05
BUCKETS = 10_000  # up to 500 ms; later ones share the last


class Lateness:
    """Counts ticks by how late they began. Percentiles are exact to 0.05 ms."""

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Begin a new measurement."""
        self._counts = [0] * BUCKETS
        self.ticks = 0
        self.skipped = 0
        self.max_ms = 0.0
        self.total_ms = 0.0

    def add(self, late_ms: float, skipped: int) -> None:
        self._counts[min(BUCKETS - 1, int(late_ms / BUCKET_MS))] += 1
        self.ticks += 1
        self.skipped += skipped
        self.total_ms += late_ms
        self.max_ms = max(self.max_ms, late_ms)

    def later_than(self, ms: float) -> int:
        """How many ticks began more than so many milliseconds late."""
        return sum(self._counts[int(ms / BUCKET_MS) :])

    def counts(self) -> tuple[dict[int, int], int, float]:
        """What was measured, for `include` in another process: ticks by bucket, ticks skipped, the maximum in ms."""
        return {index: count for index, count in enumerate(self._counts) if count}, self.skipped, self.max_ms

    def include(self, counts: tuple[dict[int, int], int, float]) -> None:
        """Add what was measured elsewhere."""
        found, skipped, max_ms = counts
        for index, count in found.items():
            self._counts[index] += count
            self.ticks += count
            self.total_ms += count * (index + 0.5) * BUCKET_MS
        self.skipped += skipped
        self.max_ms = max(self.max_ms, max_ms)

    def percentile_ms(self, share: float) -> float:
        """The lateness that `share` of the ticks do not exceed; 0 before the first tick."""
        wanted = share * self.ticks
        seen = 0
        for index, count in enumerate(self._counts):
            seen += count
            if count and seen >= wanted:
                return min(self.max_ms, (index + 1) * BUCKET_MS)
        return 0.0

    def report(self) -> dict[str, float]:
        """p50, p99, p999 and max in milliseconds."""
        shares = {"p50": 0.5, "p99": 0.99, "p999": 0.999}
        rows = {name: round(self.percentile_ms(share), 2) for name, share in shares.items()}
        return rows | {"max": round(self.max_ms, 2)}
