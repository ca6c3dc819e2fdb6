"""The three failure cases, each on an episode made to show it, and on the ones that only look like it."""

from dataclasses import replace

import numpy as np
import pytest

from movingout.maps.spec import Rect
from movingout.recordings.report.failures import Failure, fails_to_grasp, failures, keeps_at_hand_over, stays_away
from movingout.recordings.report.track import Track
from movingout.recordings.report.words import Phrase, Words
from tests.recordings.report.support import LARGE, SMALL, arena, still


def said(found: Failure) -> str:
    return Words().phrase(found.detail)


BLUE, RED = 0, 1
ITEM = 0


def hand_over(ticks: int = 60, start: int = 10, end: int = 50) -> Track:
    """Blue holds the small item; from `start` to `end` red waits beside it, nearer to the goal, with an empty hand."""
    track = still(ticks)
    track.held[:, BLUE] = ITEM
    track.robots[:, BLUE, :2] = (0.68, 0.0)
    track.items[:, ITEM, :2] = (0.5, 0.0)
    track.robots[start:end, RED, :2] = (0.3, 0.0)
    return track


# ---- 1: does not release at a hand-over --------------------------------------------------------------------


def test_holding_on_while_the_partner_waits_at_the_item_is_found_from_first_to_last_tick() -> None:
    track = hand_over()
    assert list(keeps_at_hand_over(track)) == [Failure("keeps", BLUE, ITEM, 10, 50, Phrase("detail.carried_on"))]


def test_letting_go_within_two_seconds_is_a_hand_over() -> None:
    track = hand_over()
    track.held[29:, BLUE] = -1
    assert list(keeps_at_hand_over(track)) == []
    track = hand_over()
    track.held[30:, BLUE] = -1
    assert [said(found) for found in keeps_at_hand_over(track)] == ["then let go"]


def test_pulling_on_the_same_small_item_together_is_holding_on_by_the_one_behind() -> None:
    track = hand_over()
    track.held[10:50, RED] = ITEM
    assert [found.seat for found in keeps_at_hand_over(track)] == [BLUE]


def test_two_robots_that_push_against_each_other_count_even_where_the_item_is_out_of_reach() -> None:
    track = hand_over()
    track.items[:, ITEM, :2] = (0.68, 0.2)  # beside blue
    track.robots[10:50, RED, :2] = (0.42, -0.1)
    assert [(found.start, found.end) for found in keeps_at_hand_over(track)] == [(10, 50)]


@pytest.mark.parametrize(
    "reason", ["busy partner", "partner behind", "partner far", "on the way", "delivered", "large"]
)
def test_what_only_looks_like_a_hand_over_is_not_found(reason: str) -> None:
    track = hand_over()
    if reason == "busy partner":
        track.held[:, RED] = 1
    elif reason == "partner behind":
        track.robots[:, RED, :2] = (0.9, 0.0)
    elif reason == "partner far":
        track.robots[:, RED, :2] = (0.0, 0.0)
    elif reason == "on the way":  # pushing the partner before it, three tenths of a unit a second
        way = 0.03 * np.arange(61)
        track.items[:, ITEM, 0] -= way
        track.robots[:, :, 0] -= way[:, None]
    elif reason == "delivered":
        track.delivered[:, ITEM] = True
    else:
        track.held[:, BLUE] = 1
        track.items[:, 1, :2] = (0.5, 0.0)
    assert list(keeps_at_hand_over(track)) == []


def test_a_short_interruption_does_not_end_a_finding() -> None:
    track = hand_over()
    track.robots[25:30, RED, :2] = (-0.5, -0.9)
    assert [(found.start, found.end) for found in keeps_at_hand_over(track)] == [(10, 50)]
    track.robots[25:31, RED, :2] = (-0.5, -0.9)
    assert list(keeps_at_hand_over(track)) == []  # 15 and 19 ticks


# ---- 2: does not come when help is needed ------------------------------------------------------------------


def needs_help(ticks: int = 100, start: int = 20, end: int = 90) -> Track:
    """Blue alone holds the large item from `start` to `end`; red is far away."""
    track = still(ticks)
    track.held[start:end, BLUE] = 1
    track.robots[:, BLUE, :2] = (0.76, 0.8)
    return track


def test_a_partner_that_stands_still_while_help_is_needed_is_found() -> None:
    assert list(stays_away(needs_help())) == [Failure("stays_away", RED, 1, 20, 90, Phrase("detail.stood"))]


def test_a_partner_that_carries_small_things_instead_is_found_and_they_are_named() -> None:
    track = needs_help()
    track.held[30:80, RED] = 0
    track.robots[20:90, RED, 1] += 0.02 * np.sin(np.arange(70))
    assert [said(found) for found in stays_away(track)] == ["instead carried small circle"]


def test_a_partner_that_drives_about_elsewhere_is_found_with_its_way() -> None:
    track = needs_help()
    track.robots[20:90, RED, 0] = -0.5 + 0.1 * np.sin(np.arange(70))
    (found,) = stays_away(track)
    assert said(found).startswith("drove ") and said(found).endswith(" elsewhere")


def test_a_partner_that_comes_is_not_found_even_when_it_is_slow() -> None:
    track = needs_help()
    share = np.linspace(0.0, 1.0, 101)[:, None]
    track.robots[:, RED, :2] = (1 - share) * (-0.5, -0.9) + share * (0.24, 0.8)  # 1.9 units in ten seconds
    assert list(stays_away(track)) == []


def test_a_partner_that_is_there_is_not_found() -> None:
    track = needs_help()
    track.robots[:, RED, :2] = (0.24, 0.8)
    assert list(stays_away(track)) == []


def test_five_seconds_of_waiting_pass_without_a_finding() -> None:
    assert list(stays_away(needs_help(start=20, end=70))) == []
    assert [found.end - found.start for found in stays_away(needs_help(start=20, end=71))] == [51]


def test_the_way_to_the_item_leads_around_walls() -> None:
    wall = Rect(-0.2, -1.2, -0.1, 0.6)  # red has to go up and over it
    track = replace(needs_help(), map=arena(SMALL, LARGE, walls=(wall,)))
    track.robots[:, RED, 0] = np.linspace(-0.9, -0.35, 101)  # nearer as the crow flies, no nearer on foot
    track.robots[:, RED, 1] = np.linspace(-0.4, -0.9, 101)
    assert [found.seat for found in stays_away(track)] == [RED]


def test_two_who_each_hold_a_large_item_alone_stay_away_from_each_other() -> None:
    other = replace(LARGE, id=2, pose=SMALL.pose)
    track = still(80, arena(LARGE, other))
    track.held[:, :] = (0, 1)
    assert sorted(found.seat for found in stays_away(track)) == [BLUE, RED]


# ---- 3: fails to grasp on approach -------------------------------------------------------------------------


def at_the_item(ticks: int = 60, start: int = 10, end: int = 50) -> Track:
    """Red stands before the large item, looking at it, from `start` to `end`."""
    track = still(ticks)
    track.robots[start:end, RED] = (0.5, 0.8 - 0.15 * np.sqrt(np.pi) / 2 - 0.13, 0.0)  # a square's half side below it
    return track


def test_standing_before_an_item_without_taking_it_is_found_with_its_tries() -> None:
    track = at_the_item()
    track.grasp[[20, 30], RED] = True
    assert list(fails_to_grasp(track)) == [
        Failure("no_grasp", RED, 1, 10, 50, Phrase("detail.not_taken", {"count": 2}))
    ]


def test_a_grasp_that_comes_after_three_seconds_is_said_and_one_before_is_not_found() -> None:
    track = at_the_item()
    track.held[45:, RED] = 1
    assert [said(found) for found in fails_to_grasp(track)] == ["0 tries, then took it"]
    track = at_the_item()
    track.held[39:, RED] = 1
    assert list(fails_to_grasp(track)) == []


@pytest.mark.parametrize("reason", ["looks away", "too far", "delivered", "partner holds a small one"])
def test_what_only_looks_like_an_approach_is_not_found(reason: str) -> None:
    track = at_the_item()
    if reason == "looks away":
        track.robots[:, RED, 2] = np.pi
    elif reason == "too far":
        track.robots[:, RED, 1] -= 0.12
    elif reason == "delivered":
        track.delivered[:, 1] = True
    else:
        track.items[:, 0] = track.items[:, 1]
        track.items[:, 1, :2] = (-1.0, 0.9)
        track.robots[10:50, RED, 1] = 0.8 - 0.06 - 0.13
        track.held[:, BLUE] = 0
    assert list(fails_to_grasp(track)) == []


def test_a_large_item_that_the_partner_holds_is_still_to_be_grasped() -> None:
    track = at_the_item()
    track.held[:, BLUE] = 1
    assert [found.seat for found in fails_to_grasp(track)] == [RED]


def test_whoever_begins_or_lets_go_beside_an_item_is_found_only_when_trying() -> None:
    begins = at_the_item(start=0)
    assert list(fails_to_grasp(begins)) == []
    begins.grasp[25, RED] = True
    assert [said(found) for found in fails_to_grasp(begins)] == ["1 try, did not take it"]
    lets_go = at_the_item()
    lets_go.held[:10, RED] = 1
    assert list(fails_to_grasp(lets_go)) == []


def test_grasping_and_letting_go_at_every_tick_is_not_an_empty_hand() -> None:
    track = at_the_item()
    track.held[10:50:2, RED] = 1
    track.grasp[10:50, RED] = True
    assert list(fails_to_grasp(track)) == []


def test_all_cases_of_an_episode_come_in_the_order_of_their_ticks() -> None:
    track = needs_help(ticks=120, start=50, end=115)
    track.held[5:45, BLUE] = 0
    track.robots[5:45, BLUE, :2] = (0.68, 0.0)
    track.robots[5:45, RED, :2] = (0.3, 0.0)
    assert [found.case for found in failures(track)] == ["keeps", "stays_away"]
