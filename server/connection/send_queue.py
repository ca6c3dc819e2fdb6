"""What waits to be sent to one client, and whether it keeps up. Knows no socket.

Uvicorn would buffer minutes of old frames before applying back pressure, so a client keeps up only if its
acknowledgements say so: with a second of bundles unacknowledged nothing more is sent, and once it has caught up it
gets the whole state instead of what it missed.
"""

import contextlib
from collections import deque
from collections.abc import Callable

import msgspec

from movingout.server import messages as m
from movingout.server.notices import Notice

WINDOW = 10  # unacknowledged bundles before the client counts as stalled
TOO_SLOW_S = 5.0
PAUSE_S = 1.0  # without a tick: the round is over, or stands still
CONTROL_LIMIT = 64
RTT_SAMPLES = 16
TOO_SLOW = Notice("too_slow", "This connection is too slow for the game; check the network.")


class SendQueue:
    """What waits to be sent to one browser or program.

    `write` sends a frame at once or returns False; `wake` is called when something is queued.
    """

    def __init__(self, write: Callable[[str | bytes], bool], wake: Callable[[], None]) -> None:
        self.acknowledges = True  # spectators need not
        self._held = False
        self.goodbye: tuple[int, Notice] | None = None
        self.lost = False  # to be dropped without a close frame
        self.blocked_since = 0.0  # when a frame was first refused by the connection, 0 while it takes them
        self.bytes_sent = 0
        # Round trip as the acknowledgements show it (an upper bound: they wait for the next input), -1 unknown.
        self.rtt_ms = -1.0
        self._write = write
        self._wake = wake
        self._control: deque[str | bytes] = deque()
        self._state = ""  # of the room, as it was queued last
        self._bundle: bytes | None = None
        self._under_way: deque[tuple[int, float]] = deque()  # (tick, when shown)
        self._stalled = False
        self._shown_at = 0.0
        self._rtts: deque[float] = deque(maxlen=RTT_SAMPLES)

    # ---- called by the room ---------------------------------------------------------------------------------

    def tell(self, message: m.ServerMessage, text: str = "") -> None:
        text = text or msgspec.json.encode(message).decode()
        if self._bundle is None and self._send_now(text, 0.0):
            return
        if isinstance(message, m.RoomState):
            self._replace_state(text)
        self.push(text)

    def show(self, tick: int, frame: bytes, now: float) -> None:
        if self._under_way and self._under_way[-1][0] >= tick:  # a new round counts from 1 again
            self._under_way.clear()
        if now - self._shown_at > PAUSE_S:  # nothing was asked of the client meanwhile
            self._under_way = deque((older, now) for older, _ in self._under_way)
        self._shown_at = now
        if self._too_slow(now):
            self.dismiss(m.CLOSE_TOO_SLOW, TOO_SLOW)
            return
        self._stalled = self._stalled or len(self._under_way) >= WINDOW
        if self._stalled:
            return
        if self.acknowledges:
            self._under_way.append((tick, now))
        if not self._send_now(frame, now):
            self._bundle = frame
            self._wake()

    def beat(self, frame: bytes) -> None:
        """Not sent if the last bundle has been acknowledged: nothing was lost."""
        arrived = self.acknowledges and not self._under_way
        if not (arrived or self._stalled or self._bundle):
            self._send_now(frame, 0.0)

    def acknowledge(self, tick: int, now: float) -> bool:
        while self._under_way and self._under_way[0][0] <= tick:
            shown_tick, shown = self._under_way.popleft()
            if shown_tick == tick:
                self._rtts.append((now - shown) * 1e3)
                self.rtt_ms = min(self._rtts)
        caught_up = self._stalled and not self._under_way
        self._stalled = self._stalled and not caught_up
        return caught_up

    def dismiss(self, code: int, notice: Notice) -> None:
        if self.goodbye is None:
            self.goodbye = (code, notice)
            self._wake()

    # ---- called by the socket -------------------------------------------------------------------------------

    def hold(self) -> None:
        """Queue everything until `release`."""
        self._held = True

    def release(self) -> None:
        self._held = False
        self._wake()

    def answer(self, frame: bytes) -> None:
        """Send a reply now if possible, else in its turn."""
        if not self._send_now(frame, 0.0):
            self.push(frame)

    def push(self, frame: str | bytes) -> None:
        """Queue a frame that must not be lost; a client with too many of them is dropped."""
        if len(self._control) >= CONTROL_LIMIT:
            self.lost = True
        else:
            self._keep_order()
            self._control.append(frame)
        self._wake()

    def _replace_state(self, text: str) -> None:
        """Of the states of the room only the newest waits: others may change it faster than a slow line takes it."""
        with contextlib.suppress(ValueError):
            self._control.remove(self._state)
        self._state = text

    def next_frame(self) -> str | bytes | None:
        """What to send next: control messages in order, then the newest bundle."""
        if self._held:
            return None
        if self._control:
            return self._control.popleft()
        bundle, self._bundle = self._bundle, None
        return bundle

    def _send_now(self, frame: str | bytes, now: float) -> bool:
        """Straight to the connection, unless something is waiting that has to go first."""
        if self._held:
            return False
        if self._control or not self._write(frame):
            self.blocked_since = self.blocked_since or now
            return False
        self.blocked_since = 0.0
        self.bytes_sent += len(frame)
        return True

    def _keep_order(self) -> None:
        """What is told after a bundle is sent after it."""
        if self._bundle is not None:
            self._control.append(self._bundle)
            self._bundle = None

    def _too_slow(self, now: float) -> bool:
        oldest = self._under_way[0][1] if self._under_way else now
        if self.blocked_since:
            oldest = min(oldest, self.blocked_since)
        return now - oldest > TOO_SLOW_S
