"""Who brought an item home, from the hands after each tick."""

from movingout.server.rooms.rounds.deliverers import TOGETHER_TICKS, Deliverers


def seen(items: int, *held: tuple[int, int]) -> Deliverers:
    hands = Deliverers(items)
    for tick, both in enumerate(held, start=1):
        hands.see(tick, both)
    return hands


def test_the_hands_that_held_it_last_brought_it() -> None:
    hands = seen(3, (0, -1), (-1, 1), (-1, -1))
    assert hands.of((True, True, True)) == [[0], [1], []]


def test_what_is_not_delivered_was_brought_by_nobody() -> None:
    assert seen(1, (0, 0)).of((False,)) == [[]]


def test_two_who_let_go_within_a_second_brought_it_together() -> None:
    alone = [(-1, 0)] * TOGETHER_TICKS
    assert seen(1, (0, 0), *alone).of((True,)) == [[0, 1]]
    assert seen(1, (0, 0), *alone, (-1, 0)).of((True,)) == [[1]]


def test_who_passed_it_on_long_ago_did_not_bring_it() -> None:
    passed = seen(1, (0, -1), *[(-1, -1)] * 20, (-1, 0))
    assert passed.of((True,)) == [[1]]
