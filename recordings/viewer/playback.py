"""The position on a timeline and how it moves: play, speed, step, seek. Pure: time comes in as an argument."""

from movingout.world.constants import TICK_SECONDS

SPEEDS = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0)


class Playback:
    """A play head over the ticks 0 to `last`."""

    def __init__(self, last: int) -> None:
        self.last = last
        self.playing = False
        self.speed = 1.0
        self._place = 0.0  # ticks, with fractions

    @property
    def tick(self) -> int:
        return int(self._place + 1e-9)

    def advance(self, elapsed_s: float) -> None:
        """Let real time pass; stops at the end."""
        if not self.playing:
            return
        self._place = min(self._place + elapsed_s * self.speed / TICK_SECONDS, float(self.last))
        self.playing = self._place < self.last

    def toggle(self) -> None:
        """Play or pause; at the end it starts over."""
        if not self.playing and self.tick >= self.last:
            self._place = 0.0
        self.playing = not self.playing and self.last > 0

    def seek(self, tick: int) -> None:
        self._place = float(min(max(tick, 0), self.last))

    def step(self, ticks: int) -> None:
        """Pause and move by whole ticks."""
        self.playing = False
        self.seek(self.tick + ticks)
