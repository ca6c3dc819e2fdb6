"""Candidates that an agent considered, read from a recording: paths with scores, and where it expected the items.

Two forms of a decision's `detail` are understood; anything else is not shown:
- `candidates` as objects {score, terms, x, y} (the schema of `/agent/…`): predicted paths in arena units;
- `candidates` as rows (C, H, 3) of distance, cos, sin with `scores` (C,): the commands, drawn as the way of a robot
  that nothing hinders; with `items` (C, N, 2), where the agent expected the items in the end, `guesses` (G, H, 3), the
  commands that it expected of its partner, and `robots` (R, P, 2, 2), where it expected blue and red on the way and in
  the end for each of the `pairs` (R, 2) of a candidate and a guess. Older recordings have no more than `items`.
`chosen` is an index into them.
"""

import bisect
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from movingout.recordings.episode import AgentDecision
from movingout.recordings.meshes import SEAT_RGB
from movingout.recordings.viewer.trails import segments
from movingout.world.constants import DRIVE_SPEED, TICK_SECONDS
from movingout.world.state import Floats, WorldState

HEIGHT = 0.14  # arena units above the floor, over the walls
EXPECTED_HEIGHT = 0.13  # of what is expected of the robots, below what was considered
WORST_RGB = np.array([0.60, 0.64, 0.70])
BEST_RGB = np.array([0.18, 0.49, 0.36])
CHOSEN_RGB = np.array([0.36, 0.29, 0.84])
_MOVED = 0.03  # arena units; an item expected to move less is not worth a line


class Candidate(NamedTuple):
    """One thing an agent considered."""

    path: Floats  # (P, 2) the agent's own way, arena units
    score: float
    chosen: bool
    moves: Floats  # (M, 2, 2) items expected to move: from where, to where
    robots: Floats = np.zeros((0, 1, 2, 2))  # (K, P, 2, 2) per guess: blue and red now, on the way, in the end


class Decisions:
    """The decisions of a seat that named candidates, by tick."""

    def __init__(self, decisions: Sequence[AgentDecision], seat: int, states: Sequence[WorldState]) -> None:
        self._ticks: list[int] = []
        self._considered: list[list[Candidate]] = []
        for one in decisions:
            found = candidates(one, made_in(one, states)) if one.seat == seat else []
            if found:
                self._ticks.append(one.tick)
                self._considered.append(found)

    def at(self, tick: int) -> list[Candidate]:
        """What the newest decision up to `tick` considered; empty when there was none."""
        index = bisect.bisect_right(self._ticks, tick) - 1
        return self._considered[index] if index >= 0 else []


def made_in(decision: AgentDecision, states: Sequence[WorldState]) -> WorldState:
    """The state that a decision answers to: the one before its tick."""
    return states[min(max(decision.tick - 1, 0), len(states) - 1)]


def candidates(decision: AgentDecision, state: WorldState) -> list[Candidate]:
    """The candidates of a decision that was made in `state`; empty where it told none that can be drawn."""
    told, chosen = decision.detail.get("candidates"), decision.detail.get("chosen", -1)
    if not isinstance(told, Sequence) or isinstance(told, str):
        return []
    if all(isinstance(one, Mapping) for one in told):
        return _described(told, chosen)
    return _commanded(told, chosen, decision, state)


def _described(told: Sequence[Mapping[str, object]], chosen: object) -> list[Candidate]:
    found = []
    for index, one in enumerate(told):
        x, y, score = (_numbers(one.get(name)) for name in ("x", "y", "score"))
        if x is None or y is None or score is None or x.ndim != 1 or x.shape != y.shape or not x.size or score.ndim:
            return []
        found.append(Candidate(np.column_stack([x, y]), float(score), index == chosen, np.zeros((0, 2, 2))))
    return found


def _commanded(told: Sequence[object], chosen: object, decision: AgentDecision, state: WorldState) -> list[Candidate]:
    rows, scores = _numbers(told), _numbers(decision.detail.get("scores"))
    if rows is None or scores is None or rows.ndim != 3 or rows.shape[2] != 3 or scores.shape != rows.shape[:1]:
        return []
    paths = _ways(rows, state.robot_poses[decision.seat, :2])
    moves = _moves(decision.detail.get("items"), state, len(rows))
    robots = _robots(decision.detail.get("robots"), decision.detail.get("pairs"), state, len(rows))
    return [
        Candidate(path, float(score), index == chosen, move, expected)
        for index, (path, score, move, expected) in enumerate(zip(paths, scores, moves, robots, strict=True))
    ]


def guesses(decision: AgentDecision, state: WorldState) -> Floats:
    """The ways (G, P, 2) that a decision expected of its partner; none where it told none."""
    rows = _numbers(decision.detail.get("guesses", []))
    if rows is None or rows.ndim != 3 or rows.shape[2] != 3:
        return np.zeros((0, 1, 2))
    return _ways(rows, state.robot_poses[1 - decision.seat, :2])


def _ways(rows: Floats, start: Floats) -> Floats:
    """Commands (C, H, 3) as the ways (C, H + 1, 2) of a robot that nothing hinders."""
    steps = (
        np.clip(rows[..., :1], -1.0, 1.0)
        * np.stack([-rows[..., 2], rows[..., 1]], axis=-1)
        * DRIVE_SPEED
        * TICK_SECONDS
    )
    return np.concatenate([np.broadcast_to(start, (len(rows), 1, 2)), start + np.cumsum(steps, axis=1)], axis=1)


def _moves(told: object, state: WorldState, count: int) -> list[Floats]:
    """For each candidate, the items that it expects to move."""
    now = state.item_poses[:, :2]
    ends = _numbers(told)
    if ends is None or ends.shape != (count, *now.shape):
        return [np.zeros((0, 2, 2))] * count
    far = np.linalg.norm(ends - now, axis=-1) > _MOVED
    return [np.stack([now[these], there[these]], axis=1) for there, these in zip(ends, far, strict=True)]


def _robots(told: object, pairs: object, state: WorldState, count: int) -> list[Floats]:
    """For each candidate (K, P, 2, 2) the places expected of both robots, with each guess that it was tried with."""
    places, tried = _numbers(told), _numbers(pairs)
    if places is None or tried is None or places.ndim != 4 or places.shape[2:] != (2, 2):
        return [np.zeros((0, 1, 2, 2))] * count
    if tried.shape != (len(places), 2):
        return [np.zeros((0, 1, 2, 2))] * count
    now = np.broadcast_to(state.robot_poses[:, :2], (len(places), 1, 2, 2))
    ways = np.concatenate([now, places], axis=1)
    return [ways[tried[:, 0] == index] for index in range(count)]


def _numbers(value: object) -> Floats | None:
    """Finite numbers as an array, or None."""
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        return None
    return array if np.isfinite(array).all() else None


def candidate_lines(considered: Sequence[Candidate]) -> tuple[Floats, Floats]:
    """Line segments (S, 2, 3) of all candidates and their colours (S, 2, 3) in [0, 1].

    The chosen one lies on top, with the items it expects to move and, in the colours of the seats, the ways of both
    robots, one for each guess about the partner.
    """
    points, colours = [np.zeros((0, 2, 3))], [np.zeros((0, 2, 3))]
    for candidate, colour in zip(considered, candidate_colours(considered), strict=True):
        lines = segments(candidate.path, HEIGHT + (0.01 if candidate.chosen else 0.0))
        if candidate.chosen:
            raised = np.full((*candidate.moves.shape[:2], 1), HEIGHT)
            lines = np.concatenate([lines, np.concatenate([candidate.moves, raised], axis=2)])
        points.append(lines)
        colours.append(np.broadcast_to(colour, lines.shape))
    for ways in (robots for one in considered if one.chosen for robots in one.robots):
        for seat, seat_colour in enumerate(SEAT_RGB):
            lines = segments(ways[:, seat], EXPECTED_HEIGHT)
            points.append(lines)
            colours.append(np.broadcast_to(np.array(seat_colour), lines.shape))
    return np.concatenate(points), np.concatenate(colours)


def candidate_colours(considered: Sequence[Candidate]) -> list[Floats]:
    """From grey (the worst score) to green (the best); violet for the chosen one."""
    scores = [candidate.score for candidate in considered]
    low, high = min(scores, default=0.0), max(scores, default=0.0)
    span = (high - low) or 1.0
    return [
        CHOSEN_RGB if one.chosen else WORST_RGB + (one.score - low) / span * (BEST_RGB - WORST_RGB)
        for one in considered
    ]
