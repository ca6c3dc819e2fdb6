"""Where participants wait for a partner. Nobody is paired with a closed page, and nobody waits for ever."""

from dataclasses import dataclass

GHOST_S = 20.0  # who was not heard of for so long is not paired


@dataclass
class Waiting:
    """Somebody who waits; times in seconds of the caller's clock."""

    pid: str
    since: float
    heard: float
    screen: str  # two people at one screen wait for each other alone


class WaitingRoom:
    """First come, first served; the clock is an argument."""

    def __init__(self, wait_s: float) -> None:
        self.wait_s = wait_s
        self._waiting: dict[str, Waiting] = {}

    def __len__(self) -> int:
        return len(self._waiting)

    def enter(self, pid: str, now: float, screen: str = "") -> None:
        """Begin to wait; who waits already goes on waiting."""
        self._waiting.setdefault(pid, Waiting(pid, now, now, screen))

    def begin_anew(self, now: float) -> None:
        """Nobody has waited so far: a pause does not count."""
        for one in self._waiting.values():
            one.since = now

    def leave(self, pid: str) -> None:
        self._waiting.pop(pid, None)

    def heard(self, pid: str, now: float) -> None:
        if pid in self._waiting:
            self._waiting[pid].heard = now

    def since(self, pid: str) -> float | None:
        return self._waiting[pid].since if pid in self._waiting else None

    def alive(self, now: float) -> list[Waiting]:
        """Who is really there, the longest wait first."""
        return [one for one in self._waiting.values() if now - one.heard < GHOST_S]

    def pair(self, now: float) -> tuple[str, str] | None:
        """The next two, who leave the room with that; None while there are none."""
        first: dict[str, Waiting] = {}
        for one in self.alive(now):
            if one.screen in first:
                other = first[one.screen]
                self.leave(one.pid)
                self.leave(other.pid)
                return other.pid, one.pid
            first[one.screen] = one
        return None

    def over(self, now: float) -> list[str]:
        """Who has waited long enough, present or not."""
        return [one.pid for one in self._waiting.values() if now - one.since >= self.wait_s]
