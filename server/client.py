"""What waits to be sent to one client, and how far it keeps up. Knows no socket.

Uvicorn would buffer minutes of old frames before it makes anybody wait, so a client counts as keeping up only by its
own acknowledgements: with a second of bundles unacknowledged nothing more is sent, and when it has caught up it gets
the whole state instead of what it missed.
"""

from collections import deque
from collections.abc import Callable

import msgspec

from server import messages as m

WINDOW = 10  # bundles under way before the client counts as stalled
TOO_SLOW_S = 5.0
CONTROL_LIMIT = 64
RTT_SAMPLES = 16


class Client:
    """One connection of a browser or a program. `wake` is called when there is something to send."""

    def __init__(self, wake: Callable[[], None]) -> None:
        self.acknowledges = True  # spectators need not
        self.goodbye: tuple[int, str] | None = None
        self.lost = False  # to be cut off without a word
        self.sending_since = 0.0  # when the frame now being written was handed over, 0 for none
        self.bytes_sent = 0
        self._wake = wake
        self._control: deque[str | bytes] = deque()
        self._bundle: bytes | None = None
        self._beat: bytes | None = None
        self._under_way: deque[tuple[int, float]] = deque()  # (tick, when shown)
        self._stalled = False
        self._rtts: deque[float] = deque(maxlen=RTT_SAMPLES)

    @property
    def rtt_ms(self) -> float:
        """Round trip as the acknowledgements show it (an upper bound: they wait for the next input), -1 unknown."""
        return min(self._rtts) if self._rtts else -1.0

    # ---- called by the room ---------------------------------------------------------------------------------

    def tell(self, message: m.ServerMessage, text: str = "") -> None:
        self.push(text or msgspec.json.encode(message).decode())

    def show(self, tick: int, frame: bytes, now: float) -> None:
        if self._too_slow(now):
            self.dismiss(m.CLOSE_TOO_SLOW, "This connection is too slow for the game; check the network.")
            return
        if self._under_way and self._under_way[-1][0] >= tick:  # a new round counts from 1 again
            self._under_way.clear()
        self._stalled = self._stalled or len(self._under_way) >= WINDOW
        if self._stalled:
            return
        if self.acknowledges:
            self._under_way.append((tick, now))
        self._bundle = frame
        self._wake()

    def beat(self, frame: bytes) -> None:
        if not self._stalled:
            self._beat = frame
            self._wake()

    def acknowledge(self, tick: int, now: float) -> bool:
        while self._under_way and self._under_way[0][0] <= tick:
            shown_tick, shown = self._under_way.popleft()
            if shown_tick == tick:
                self._rtts.append((now - shown) * 1e3)
        caught_up = self._stalled and not self._under_way
        self._stalled = self._stalled and not caught_up
        return caught_up

    def dismiss(self, code: int, message: str) -> None:
        if self.goodbye is None:
            self.goodbye = (code, message)
            self._wake()

    # ---- called by the socket -------------------------------------------------------------------------------

    def push(self, frame: str | bytes) -> None:
        """Queue a frame that must not be lost; a client with too many of them waiting is cut off."""
        if len(self._control) >= CONTROL_LIMIT:
            self.lost = True
        else:
            self._keep_order()
            self._control.append(frame)
        self._wake()

    def next_frame(self) -> str | bytes | None:
        """What to send next: control messages in order, then the newest bundle, then the beat."""
        if self._control:
            return self._control.popleft()
        bundle, beat = self._bundle, self._beat
        self._bundle = self._beat = None
        return bundle or beat

    def _keep_order(self) -> None:
        """What is told after a bundle is sent after it."""
        if self._bundle is not None:
            self._control.append(self._bundle)
            self._bundle = self._beat = None

    def _too_slow(self, now: float) -> bool:
        oldest = self._under_way[0][1] if self._under_way else now
        if self.sending_since:
            oldest = min(oldest, self.sending_since)
        return now - oldest > TOO_SLOW_S
