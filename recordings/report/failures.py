"""The paper's three failure cases, found in recorded states by rules: where to look, not whose fault it was.

Source: the paper's "Failure case study (RQ5)", figure "Failure cases": 1) failing to release items during a
hand-over, 2) not responding when assistance is needed, 3) inability to grasp large items upon approach. The paper
counted by manual inspection and gives no rules; the rules and thresholds here are this project's.

Every rule looks for a condition that holds over consecutive ticks; gaps of up to `GAP` ticks are bridged.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from movingout.maps.spec import ROBOT_RADIUS
from movingout.recordings.report.track import Ints, Mask, Span, Track, spans
from movingout.recordings.report.words import Phrase
from movingout.world.constants import TICK_SECONDS
from movingout.world.distance import paper_distances
from movingout.world.state import Floats

Case = Literal["keeps", "stays_away", "no_grasp"]
CASES: tuple[Case, ...] = get_args(Case)

GAP = 5  # ticks
KEEPS_TICKS = 20  # 2 s
KEEPS_REACH = ROBOT_RADIUS + 0.10  # from the partner's centre to the item: within reach after turning
KEEPS_TOUCH = 2 * ROBOT_RADIUS + 0.05  # between the two centres: they touch
KEEPS_LOOK_BACK = 10  # ticks over which progress is measured
KEEPS_PROGRESS = 0.10  # arena units nearer to the goal in that time; a free robot carries 0.6 per second
HELP_TICKS = 50  # 5 s
HELP_APPROACH = 0.30  # arena units nearer in that time, around walls; a robot can drive 3.0
HELP_THERE = ROBOT_RADIUS + 0.15  # from the partner's centre to the item: it has arrived
GRASP_TICKS = 30  # 3 s
GRASP_NEAR = 0.08  # from the grasp probe to the item; the world grasps within 0.04


@dataclass(frozen=True, slots=True)
class Failure:
    """One failure case in an episode."""

    case: Case
    seat: int  # who failed
    item: int  # index
    start: int  # first tick
    end: int  # first tick after
    detail: Phrase

    @property
    def seconds(self) -> float:
        return (self.end - self.start) * TICK_SECONDS


def failures(track: Track) -> list[Failure]:
    """All failure cases of an episode, by start."""
    found = [*keeps_at_hand_over(track), *stays_away(track), *fails_to_grasp(track)]
    return sorted(found, key=lambda failure: (failure.start, failure.seat))


def keeps_at_hand_over(track: Track) -> Iterator[Failure]:
    """Case 1, "frequently holds an item without passing it, resulting in frequent collisions".

    For 2 s a seat holds an undelivered small item (one that a single robot carries), while its partner
    - has an empty hand, or holds the same item,
    - is nearer to the goal than the item is (both around walls),
    - has its rim within 0.10 of the item, or touches the holder,
    and the item gets less than 0.10 nearer to the goal in any second of it. The failure is the holder's.
    """
    for item in range(len(track.map.items)):
        if track.is_big(item):
            continue
        for seat in (0, 1):
            held, partner = track.held[:, seat] == item, track.held[:, 1 - seat]
            if not held.any():
                continue
            condition = held & ((partner == -1) | (partner == item)) & ~track.delivered[:, item]
            condition &= _partner_is_there(track, seat, item) & _is_stuck(track, item)
            for span in spans(condition, KEEPS_TICKS, GAP):
                yield Failure("keeps", seat, item, *span, _how_it_ended(track, seat, item, span))


def stays_away(track: Track) -> Iterator[Failure]:
    """Case 2, a partner "was slowly pulling an item, but the AI agent instead went to grasp other smaller objects".

    One seat alone holds an undelivered middle or large item; over 5 s of this the other seat gets less than 0.30 nearer
    to that item (around walls, or in a straight line where the grid has no path) and is not there already (its rim
    within 0.15). The failure is the other seat's, from the start of the first such 5 s to the end of the last.
    """
    for item in range(len(track.map.items)):
        if not track.is_big(item):
            continue
        for seat in (0, 1):
            for waiting in spans(track.alone(seat, item), HELP_TICKS + 1):
                away = _does_not_come(track, 1 - seat, item, waiting)
                for span in spans(away, HELP_TICKS, GAP):
                    where = span.later(waiting.start)
                    yield Failure("stays_away", 1 - seat, item, *where, _instead(track, 1 - seat, where))


def fails_to_grasp(track: Track) -> Iterator[Failure]:
    """Case 3, "the AI agent reached the target item but was unable to successfully grasp it".

    For 3 s a seat has an empty hand and one undelivered item within 0.08 of its grasp point (the nearest item counts; a
    small item held by the partner does not). The seat must have arrived with that empty hand, or try to grasp: a stay
    that begins with the episode, or with a release, counts only when a grasp was commanded in it.
    """
    for seat in (0, 1):
        target = _target(track, seat)
        for empty in spans(track.held[:, seat] == -1, GRASP_TICKS):
            for item in set(target[empty.start : empty.end].tolist()) - {-1}:
                for stay in spans(target[empty.start : empty.end] == item, GRASP_TICKS, GAP):
                    span = stay.later(empty.start)
                    attempts = _attempts(track, seat, span)
                    if attempts or span.start > empty.start:
                        yield Failure("no_grasp", seat, item, *span, _tries(track, seat, item, span, attempts))


# ---- case 1 ------------------------------------------------------------------------------------------------


def _partner_is_there(track: Track, seat: int, item: int) -> Mask:
    """(T + 1,) whether the partner is near enough to take the item, and nearer to the goal than it."""
    partner, holder = track.robots[:, 1 - seat, :2], track.robots[:, seat, :2]
    reaches = track.clearance(item, partner) <= KEEPS_REACH
    touches = np.linalg.norm(partner - holder, axis=1) <= KEEPS_TOUCH
    nearer = track.to_goal(partner) < track.to_goal(track.items[:, item, :2])
    there: Mask = (reaches | touches) & nearer
    return there


def _is_stuck(track: Track, item: int) -> Mask:
    """(T + 1,) whether the item moved little in the last second; False in the first second, where it is unknown."""
    way = track.to_goal(track.items[:, item, :2])
    stuck = np.zeros(len(way), dtype=np.bool_)
    stuck[KEEPS_LOOK_BACK:] = way[:-KEEPS_LOOK_BACK] - way[KEEPS_LOOK_BACK:] < KEEPS_PROGRESS
    return stuck


def _how_it_ended(track: Track, seat: int, item: int, span: Span) -> Phrase:
    later = track.held[span.end :]
    if not len(later):
        return Phrase("detail.until_end")
    if later[0, seat] != item:
        return Phrase("detail.let_go")
    return Phrase("detail.carried_on")


# ---- case 2 ------------------------------------------------------------------------------------------------


def _does_not_come(track: Track, helper: int, item: int, waiting: Span) -> Mask:
    """(ticks,) whether a tick of the wait is part of 5 s in which the helper neither got nearer nor was there."""
    ticks = slice(waiting.start, waiting.end)
    way = _ways(track, helper, item, ticks)
    there = track.clearance(item, track.robots[:, helper, :2])[ticks] <= HELP_THERE
    away = np.zeros(waiting.ticks, dtype=np.bool_)
    for end in range(HELP_TICKS, waiting.ticks):
        start = end - HELP_TICKS
        if way[start] - way[end] < HELP_APPROACH and not there[start : end + 1].any():
            away[start : end + 1] = True
    return away


def _ways(track: Track, helper: int, item: int, ticks: slice) -> Floats:
    """(ticks,) distance from the helper to the item: around walls, or straight where the grid has no path."""
    distances = paper_distances(track.map)
    robots, items = track.robots[ticks, helper, :2], track.items[ticks, item, :2]
    around = np.array([distances.between(robot, there) for robot, there in zip(robots, items, strict=True)])
    return np.where(np.isfinite(around), around, np.linalg.norm(robots - items, axis=1))


def _instead(track: Track, helper: int, span: Span) -> Phrase:
    held = track.held[span.start : span.end, helper]
    others = sorted(set(held[held >= 0].tolist()))
    if others:
        return Phrase("detail.carried_others", {"items": [track.map.items[index] for index in others]})
    places = track.robots[span.start : span.end, helper, :2]
    moved = float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum())
    return Phrase("detail.stood") if moved < HELP_APPROACH else Phrase("detail.drove", {"way": moved})


# ---- case 3 ------------------------------------------------------------------------------------------------


def _target(track: Track, seat: int) -> Ints:
    """(T + 1,) the item within reach of an empty hand, -1 for none."""
    probe = track.probe(seat)
    gaps = np.stack([track.clearance(item, probe) for item in range(len(track.map.items))], axis=1)
    for item in range(len(track.map.items)):
        taken = (track.held[:, 1 - seat] == item) & (not track.is_big(item))
        gaps[track.delivered[:, item] | taken, item] = np.inf
    nearest = gaps.argmin(axis=1)
    at = (gaps.min(axis=1) <= GRASP_NEAR) & (track.held[:, seat] == -1)
    return np.where(at, nearest, -1)


def _attempts(track: Track, seat: int, span: Span) -> int:
    """How many commanded grasps left the hand empty."""
    end = min(span.end, len(track.grasp))
    empty_after = track.held[span.start + 1 : end + 1, seat] == -1
    return int((track.grasp[span.start : end, seat] & empty_after).sum())


def _tries(track: Track, seat: int, item: int, span: Span, attempts: int) -> Phrase:
    taken = span.end < len(track.held) and track.held[span.end, seat] == item
    return Phrase("detail.took" if taken else "detail.not_taken", {"count": attempts})
