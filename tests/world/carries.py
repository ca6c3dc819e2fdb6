"""Episodes in which every kind of carrying and of letting go happens, on maps without walls."""

from collections.abc import Callable

from tests.world.support import BLUE, CIRCLE, RED, Script


def hold_small() -> Script:
    script = Script("Simple")
    script.grab(RED, CIRCLE)
    script.alone(RED, 0.7, 8)
    return script


def hold_middle_alone() -> Script:
    script = Script("DistancePriority")
    script.grab(BLUE, CIRCLE)
    script.alone(BLUE, -1.0, 12)
    return script


def hold_middle_with_two() -> Script:
    script = hold_middle_alone()
    script.walk(RED, (-0.8, 0.1), (script.world.state().item_poses[CIRCLE, 0], 0.1))
    script.grab(RED, CIRCLE)
    script.both(0.4, 12)
    return script


def hold_large_alone() -> Script:
    script = Script("LeftRight")
    script.drive(BLUE, -0.6, -0.4)
    script.grab(BLUE, CIRCLE)
    script.alone(BLUE, 1.0, 6)
    return script


def hold_large_with_two() -> Script:
    script = hold_large_alone()
    script.drive(RED, 0.6, -0.4)
    script.grab(RED, CIRCLE)
    script.both(2.5, 12)
    return script


HOLDS: dict[str, Callable[[], Script]] = {
    "small": hold_small,
    "middle alone": hold_middle_alone,
    "middle with two": hold_middle_with_two,
    "large alone": hold_large_alone,
    "large with two": hold_large_with_two,
}


def hand_over_small() -> Script:
    script = hold_small()
    script.toggle(RED)
    script.walk(RED, (0.5, -0.3))
    script.walk(BLUE, (-0.9, -0.9), (-0.9, -0.45))
    script.grab(BLUE, CIRCLE)
    script.alone(BLUE, 0.5, 10)
    script.toggle(BLUE)
    return script


def both_reach_for_a_small_item() -> Script:
    """Only one of them gets it; what the other does is let go of nothing."""
    script = Script("Simple")
    x, y, _ = script.world.state().item_poses[CIRCLE]
    script.walk(BLUE, (-0.9, -0.9), (-0.9, -0.45), (0.5, -0.45))
    script.drive(BLUE, x, y, near=0.19)
    script.drive(RED, x, y, near=0.19)
    script.toggle_both()
    script.both(0.5, 8)
    script.toggle_both()
    script.both(-1.0, 5)
    return script


def middle_passed_on() -> Script:
    """The first to take it lets go first: the other drags it on alone."""
    script = hold_middle_with_two()
    script.toggle(BLUE)
    script.alone(RED, 0.6, 15)
    script.toggle(RED)
    script.alone(RED, 3.0, 3)
    return script


def middle_taken_again() -> Script:
    """The second lets go and takes hold again; then both let go in one tick."""
    script = hold_middle_with_two()
    script.toggle(RED)
    script.alone(BLUE, 0.2, 10)
    script.toggle(RED)
    script.both(-0.5, 10)
    script.toggle_both()
    script.both(3.0, 3)
    return script


def large_left_by_the_first() -> Script:
    script = hold_large_with_two()
    script.toggle(BLUE)
    script.alone(RED, 1.0, 8)
    script.toggle(RED)
    script.alone(RED, -1.0, 3)
    return script


def large_taken_again() -> Script:
    """The second lets go, takes hold again, and both let go in one tick."""
    script = hold_large_with_two()
    script.toggle(RED)
    script.alone(BLUE, 1.0, 5)
    script.toggle(RED)
    script.both(-2.0, 12)
    script.toggle_both()
    script.both(1.0, 4)
    return script


def two_items_let_go_in_turn() -> Script:
    """Each carries its own; the first to let go changes the order in which the engine solves the rest."""
    script = Script("DistancePriority")
    script.grab(BLUE, CIRCLE)
    script.walk(RED, (-0.75, -0.9), (0.1, -0.92))
    script.drive(RED, 0.4, -0.7, near=0.22)
    script.toggle(RED)
    script.both(0.8, 10)
    script.toggle(BLUE)
    script.both(-0.8, 10)
    script.toggle(RED)
    script.both(2.0, 4)
    return script


EPISODES: dict[str, Callable[[], Script]] = {
    **HOLDS,
    "hand over small": hand_over_small,
    "both reach for a small item": both_reach_for_a_small_item,
    "middle passed on": middle_passed_on,
    "middle taken again": middle_taken_again,
    "large left by the first": large_left_by_the_first,
    "large taken again": large_taken_again,
    "two items let go in turn": two_items_let_go_in_turn,
}
