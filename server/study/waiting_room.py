"""The queue of participants without a partner. Closed pages are never paired, and every wait ends."""

from dataclasses import dataclass

ABSENT_S = 20.0  # a page that was silent for so long counts as closed


@dataclass
class WaitingParticipant:
    """Times in seconds of the caller's clock."""

    pid: str
    since: float
    heard: float
    screen: str  # two people at one screen are paired with each other only


class WaitingRoom:
    """First come, first served. The current time is an argument of each method."""

    def __init__(self, wait_s: float) -> None:
        self.wait_s = wait_s
        self._waiting: dict[str, WaitingParticipant] = {}

    def __len__(self) -> int:
        return len(self._waiting)

    def enter(self, pid: str, now: float, screen: str = "") -> None:
        """Begin to wait; of somebody who is waiting already, only the screen may be another one."""
        self._waiting.setdefault(pid, WaitingParticipant(pid, now, now, screen)).screen = screen

    def wait_anew(self, pid: str, now: float) -> None:
        """Their wait begins now: the other one at their screen is still on the way."""
        self._waiting[pid].since = now

    def restart_waits(self, now: float) -> None:
        """All waits begin now: a pause does not count."""
        for one in self._waiting.values():
            one.since = now

    def leave(self, pid: str) -> None:
        self._waiting.pop(pid, None)

    def heard(self, pid: str, now: float) -> None:
        if pid in self._waiting:
            self._waiting[pid].heard = now

    def since(self, pid: str) -> float | None:
        return self._waiting[pid].since if pid in self._waiting else None

    def present(self, now: float) -> list[WaitingParticipant]:
        """Those whose page is open, the longest wait first."""
        return [one for one in self._waiting.values() if now - one.heard < ABSENT_S]

    def pair(self, now: float) -> tuple[str, str] | None:
        """Remove and return the next pair; None while there is none."""
        first: dict[str, WaitingParticipant] = {}
        for one in self.present(now):
            if one.screen in first:
                other = first[one.screen]
                self.leave(one.pid)
                self.leave(other.pid)
                return other.pid, one.pid
            first[one.screen] = one
        return None

    def timed_out(self, now: float) -> list[str]:
        """Those who have waited for `wait_s`, present or not."""
        return [one.pid for one in self._waiting.values() if now - one.since >= self.wait_s]
