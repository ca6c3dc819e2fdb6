"""What is drawn over the bodies, as arrays: trails, an agent's candidates. Knows no viewer."""

import bisect
from collections.abc import Mapping, Sequence
from typing import NamedTuple, cast

import numpy as np

from recordings.episode import AgentDecision
from world.state import Floats, WorldState

TRAIL_HEIGHT = 0.012  # arena units above the floor
CANDIDATE_HEIGHT = 0.14  # above the walls
WORST_RGB = np.array([0.60, 0.64, 0.70])
BEST_RGB = np.array([0.18, 0.49, 0.36])
CHOSEN_RGB = np.array([0.36, 0.29, 0.84])


class Candidate(NamedTuple):
    """One thing an agent considered."""

    path: Floats  # (P, 2) predicted way, arena units
    score: float
    chosen: bool


def trail(states: Sequence[WorldState], seat: int, tick: int, ticks: int) -> Floats:
    """Line segments (S, 2, 3) along a robot's way in the last `ticks` ticks; one point when it has no past."""
    first = max(0, tick - ticks)
    points = np.array([states[k].robot_poses[seat, :2] for k in range(first, tick + 1)])
    if len(points) == 1:
        points = np.repeat(points, 2, axis=0)
    return _segments(points, TRAIL_HEIGHT)


class Decisions:
    """An agent's decisions that named candidates, by tick."""

    def __init__(self, decisions: Sequence[AgentDecision], seat: int) -> None:
        told = [one for one in decisions if one.seat == seat and one.detail.get("candidates")]
        self._ticks = [one.tick for one in told]
        self._considered = [candidates(one) for one in told]

    def at(self, tick: int) -> list[Candidate]:
        """What the newest decision up to `tick` considered; empty when there was none."""
        index = bisect.bisect_right(self._ticks, tick) - 1
        return self._considered[index] if index >= 0 else []


def candidates(decision: AgentDecision) -> list[Candidate]:
    """The candidates of a decision, as `recordings.topics` defines them: score, terms, x, y."""
    found = cast(Sequence[Mapping[str, Sequence[float]]], decision.detail.get("candidates", ()))
    chosen = decision.detail.get("chosen", -1)
    return [
        Candidate(np.column_stack([one["x"], one["y"]]).reshape(-1, 2), float(cast(float, one["score"])), k == chosen)
        for k, one in enumerate(found)
    ]


def candidate_lines(considered: Sequence[Candidate]) -> tuple[Floats, Floats]:
    """Line segments (S, 2, 3) of all candidates and their colours (S, 2, 3) in [0, 1]; the chosen one lies on top."""
    points, colours = [], []
    for candidate, colour in zip(considered, candidate_colours(considered), strict=True):
        height = CANDIDATE_HEIGHT + (0.01 if candidate.chosen else 0.0)
        segments = _segments(candidate.path, height)
        points.append(segments)
        colours.append(np.broadcast_to(colour, segments.shape))
    if not points:
        return np.zeros((0, 2, 3)), np.zeros((0, 2, 3))
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


def _segments(points: Floats, height: float) -> Floats:
    raised = np.column_stack([points, np.full(len(points), height)])
    segments: Floats = np.stack([raised[:-1], raised[1:]], axis=1)
    return segments
