"""The waiting room, with a clock that the test controls."""

from movingout.server.study.waiting_room import ABSENT_S, WaitingRoom


def test_who_came_first_is_paired_first() -> None:
    room = WaitingRoom(300)
    for second, pid in enumerate(("P1", "P2", "P3")):
        room.enter(pid, float(second))
    assert room.pair(3.0) == ("P1", "P2")
    assert room.pair(3.0) is None and len(room) == 1


def test_nobody_is_paired_with_a_closed_page() -> None:
    room = WaitingRoom(300)
    room.enter("P1", 0.0)
    room.enter("P2", 0.0)
    room.heard("P2", ABSENT_S + 1)
    assert room.pair(ABSENT_S + 1) is None
    room.heard("P1", ABSENT_S + 2)
    assert room.pair(ABSENT_S + 2) == ("P1", "P2"), "the page is open again"


def test_two_at_one_screen_wait_for_each_other_alone() -> None:
    room = WaitingRoom(300)
    room.enter("P1", 0.0, "a1")
    room.enter("P2", 1.0)
    assert room.pair(2.0) is None
    room.enter("P3", 2.0, "a1")
    assert room.pair(3.0) == ("P1", "P3")


def test_who_waits_at_a_screen_alone_again_waits_for_anybody() -> None:
    room = WaitingRoom(300)
    room.enter("P1", 0.0, "a1")
    room.enter("P2", 1.0)
    room.enter("P1", 2.0, "")
    assert (room.since("P1"), room.pair(3.0)) == (0.0, ("P1", "P2"))


def test_nobody_waits_longer_than_was_said_and_coming_again_does_not_begin_anew() -> None:
    room = WaitingRoom(300)
    room.enter("P1", 0.0)
    room.enter("P1", 200.0)
    assert room.timed_out(299.0) == []
    assert (room.timed_out(300.0), room.since("P1")) == (["P1"], 0.0)
    room.leave("P1")
    assert (room.timed_out(300.0), room.since("P1")) == ([], None)


def test_who_waited_through_a_pause_waits_anew() -> None:
    room = WaitingRoom(300)
    room.enter("P1", 0.0)
    room.restart_waits(400.0)
    assert (room.timed_out(699.0), room.timed_out(700.0)) == ([], ["P1"])
