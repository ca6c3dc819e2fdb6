"""What is sent to one client: order, backpressure, rate."""

from movingout.server import messages as m
from movingout.server.connection.send_queue import CONTROL_LIMIT, WINDOW, SendQueue
from movingout.server.connection.token_bucket import TokenBucket
from movingout.server.rooms.input_buffer import MAX_PRESSES, InputBuffer
from tests.server.support import make_input


class Line:
    """A connection that can be blocked."""

    def __init__(self) -> None:
        self.blocked = False
        self.written: list[str | bytes] = []
        self.client = SendQueue(self.write, lambda: None)

    def write(self, frame: str | bytes) -> bool:
        if not self.blocked:
            self.written.append(frame)
        return not self.blocked

    def flush(self) -> list[str | bytes]:
        frames = []
        while (frame := self.client.next_frame()) is not None:
            frames.append(frame)
        return frames


def room_state(reason: str) -> m.RoomState:
    return m.RoomState(phase="paused", reason=reason, until_ms=0.0, seats=[], spectators=0, recording=True)


def test_a_bundle_goes_straight_to_the_connection() -> None:
    line = Line()
    line.client.show(1, b"one", 0.0)
    line.client.beat(b"beat")
    assert line.written == [b"one", b"beat"]
    assert line.client.next_frame() is None


def test_a_beat_is_left_out_when_the_bundle_has_arrived_already() -> None:
    line = Line()
    line.client.show(1, b"one", 0.0)
    line.client.acknowledge(1, 0.02)
    line.client.beat(b"beat")
    line.client.show(2, b"two", 0.1)
    line.client.beat(b"beat")
    assert line.written == [b"one", b"two", b"beat"]


def test_while_the_connection_is_blocked_only_the_newest_bundle_waits() -> None:
    line = Line()
    line.blocked = True
    for tick in (1, 2, 3):
        line.client.show(tick, b"%d" % tick, tick / 10)
        line.client.beat(b"beat")
    line.blocked = False
    assert line.flush() == [b"3"]


def test_what_is_told_after_a_bundle_is_sent_after_it() -> None:
    line = Line()
    line.blocked = True
    line.client.show(1, b"last tick", 0.1)
    line.client.tell(m.Problem("over", "the result"))
    line.client.show(2, b"newer", 0.2)
    line.blocked = False
    bundle, told, newer = line.flush()
    assert (bundle, newer) == (b"last tick", b"newer")
    assert isinstance(told, str) and "the result" in told


def test_of_the_states_of_a_room_only_the_newest_waits() -> None:
    line = Line()
    line.blocked = True
    line.client.tell(m.Problem("no_room", "first"))
    for number in range(10 * CONTROL_LIMIT):
        line.client.tell(room_state(reason=f"change {number}"))
    line.client.tell(m.Problem("no_room", "last"))
    waits = line.flush()
    assert not line.client.lost and len(waits) == 3
    assert "first" in str(waits[0]) and f"change {10 * CONTROL_LIMIT - 1}" in str(waits[1]) and "last" in str(waits[2])


def test_a_client_that_acknowledges_nothing_gets_no_more_than_a_window() -> None:
    line = Line()
    for tick in range(1, 30):
        line.client.show(tick, b"x", tick / 10)
    assert len(line.written) == WINDOW
    assert not line.client.acknowledge(3, 3.0)
    assert line.client.acknowledge(WINDOW, 3.0), "caught up: it needs the whole state"
    line.client.show(31, b"y", 3.1)
    assert line.written[-1] == b"y"


def test_a_client_that_is_five_seconds_behind_is_dismissed() -> None:
    line = Line()
    for tick in range(1, 60):
        line.client.show(tick, b"x", tick / 10)
    assert line.client.goodbye is not None
    assert line.client.goodbye[0] == m.CLOSE_TOO_SLOW


def test_a_spectator_is_dismissed_only_when_its_connection_is_blocked() -> None:
    line = Line()
    line.client.acknowledges = False
    for tick in range(1, 100):
        line.client.show(tick, b"x", tick / 10)
    assert line.client.goodbye is None and len(line.written) == 99
    line.blocked = True
    for tick in range(100, 160):
        line.client.show(tick, b"x", tick / 10)
    assert line.client.goodbye is not None


def test_the_ticks_of_a_new_round_count_from_one_again() -> None:
    line = Line()
    for tick in (8, 9, 10):
        line.client.show(tick, b"x", tick / 10)
    line.client.show(1, b"y", 2.0)
    assert not line.client.acknowledge(1, 2.05)
    assert round(line.client.rtt_ms) == 50


def test_the_round_trip_is_the_shortest_of_late() -> None:
    line = Line()
    assert line.client.rtt_ms == -1.0
    for tick, delay in ((1, 0.08), (2, 0.04), (3, 0.06)):
        line.client.show(tick, b"x", tick / 10)
        line.client.acknowledge(tick, tick / 10 + delay)
    assert round(line.client.rtt_ms) == 40


def test_a_control_message_goes_straight_to_the_connection_unless_something_waits_that_has_to_go_first() -> None:
    line = Line()
    line.client.tell(m.Problem("now", "at once"))
    line.blocked = True
    line.client.show(1, b"last tick", 0.1)
    line.blocked = False
    line.client.tell(m.Problem("over", "the result"))
    (told,) = line.written
    assert isinstance(told, str) and "at once" in told
    bundle, result = line.flush()
    assert bundle == b"last tick"
    assert isinstance(result, str) and "the result" in result


def test_too_many_waiting_control_messages_cut_the_client_off() -> None:
    line = Line()
    line.blocked = True
    for _ in range(CONTROL_LIMIT):
        line.client.tell(m.Problem("x", "y"))
    assert not line.client.lost
    line.client.tell(m.Problem("x", "y"))
    assert line.client.lost
    assert len(line.flush()) == CONTROL_LIMIT


def test_a_bucket_gives_its_burst_and_then_its_rate() -> None:
    bucket = TokenBucket(per_s=60, burst=60, now=0.0)
    assert sum(bucket.take(0.0) for _ in range(100)) == 60
    assert sum(bucket.take(1.0) for _ in range(100)) == 60
    assert sum(bucket.take(1.0 + count / 50) for count in range(1, 51)) == 50, "50 a second pass for ever"


def test_controls_keep_the_newest_stick_and_count_presses() -> None:
    controls = InputBuffer()
    assert controls.tick_input(0.0).seq == -1
    assert controls.submit(make_input(seq=5, move=0.5, heading=1.0, grabs=2, device=1), 0.0)
    assert not controls.submit(make_input(seq=5, move=1.0, heading=1.0, grabs=3, device=1), 0.0)
    assert not controls.submit(make_input(seq=4, move=1.0, heading=1.0, grabs=9, device=1), 0.0)
    inputs = [controls.tick_input(0.04) for _ in range(3)]
    assert [each.action for each in inputs] == [(0.5, 1.0, 1.0), (0.5, 1.0, 1.0), (0.5, 1.0, 0.0)]
    assert (inputs[0].seq, round(inputs[0].slack_ms), controls.device) == (5, 40, "gamepad")
    assert controls.submit(make_input(seq=6, move=0.5, heading=1.0, grabs=202, device=1), 0.1)
    assert sum(controls.tick_input(0.1).action[2] for _ in range(20)) == MAX_PRESSES


def test_released_controls_stand_still_and_forget_presses() -> None:
    controls = InputBuffer()
    controls.submit(make_input(move=1.0, heading=1.0, grabs=1), 0.0)
    controls.release()
    assert controls.tick_input(0.0).action == (0.0, 1.0, 0.0)


def test_the_first_tick_after_a_pause_finds_nobody_too_slow() -> None:
    """The last bundle of a round is not acknowledged: the page sends no inputs between rounds, nor while it waits."""
    line = Line()
    for tick in (499, 500):
        line.client.show(tick, b"last", tick / 10)
    line.client.show(1, b"first of the next round", 62.0)
    assert line.client.goodbye is None and line.written[-1] == b"first of the next round"
    line.client.show(2, b"two", 62.1)
    line.client.show(3, b"after a partner was away", 92.0)
    assert line.client.goodbye is None
    for tick in range(4, 80):
        line.client.show(tick, b"unread", 92.0 + tick / 10)
    assert line.client.goodbye is not None, "who acknowledges nothing while ticks come is too slow"
