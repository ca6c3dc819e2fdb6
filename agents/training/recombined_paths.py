"""How diverse recombined episodes are, and how many pieces the engine confirms (`agents.bass.recombination`).

For diversity, an episode is recombined as the paper's example is: from a matching stretch on, the partner goes the rest
of its way in the other episode. What agents learn from are pieces of a few ticks, of which the share of valid ones is
measured.
"""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from itertools import islice

import numpy as np

from movingout.agents.bass.recombination import (
    LENGTH,
    LearnedPart,
    Matching,
    RecombinationReport,
    RecombinedPiece,
    augmentation,
    draw_pieces,
)
from movingout.agents.data.dataset import SeatChoice, Trajectory, imitated_seats, learned_seats, trajectory_of
from movingout.agents.data.diversity import path_of
from movingout.recordings.diversity.augmented import PATHS, AugmentedPopulation, Recombination
from movingout.recordings.diversity.episodes import PathEpisode
from movingout.world.estimates import Estimate
from movingout.world.state import Floats

PIECES = 4  # recombined paths per recorded one, at most
_MATCHINGS: dict[str, Matching] = {"recombined": "both-ends", "recombined, single-agent": "either-end"}
_METHOD = (
    "Recombined: from a stretch on that starts and ends as one of another episode of the population, the partner goes "
    f"the rest of its way there; beside the recorded paths up to {PIECES} such paths for each (of all of them {PATHS} "
    "per map, or as many as were recorded). Single-agent, as in the paper: the stretch starts or ends alike, and "
    "agents learn from it unconfirmed by the engine. Valid: the share that the engine confirms of pieces of "
    f"{LENGTH} ticks, on all maps of the population; ± is the binomial standard error."
)


def whole_parts(trajectories: Sequence[Trajectory], choice: SeatChoice) -> list[LearnedPart]:
    """The seats of whole episodes that agents learn from."""
    return [
        LearnedPart(one, seat, one.targets(seat, "toggle"), ((0, one.ticks),))
        for one in trajectories
        for seat in learned_seats(one, choice)
    ]


def recombined_paths(
    parts: Sequence[LearnedPart], episodes: int, seed: int, matching: Matching
) -> list[tuple[str, Floats]]:
    """Names of maps and paths (T + 1, 4), at most `PIECES` per episode; none where no two stretches match."""
    pieces = islice(draw_pieces(parts, seed, matching), PIECES * episodes)
    return [(piece.own.trajectory.map.name, exchanged(piece)) for piece in pieces]


def exchanged(piece: RecombinedPiece) -> Floats:
    """(T + 1, 4) the own way, and from the piece on the partner's way in the other episode, as far as it goes."""
    path, seat = path_of(piece.own.trajectory).copy(), 1 - piece.own.seat
    rest = piece.other.robot_poses[piece.other_start :, seat, :2]
    length = min(len(path) - piece.start, len(rest))
    path[piece.start : piece.start + length, 2 * seat : 2 * seat + 2] = rest[:length]
    cut: Floats = path[: piece.start + length]
    return cut


def valid_share(parts: Sequence[LearnedPart], pieces: int, seed: int, matching: Matching) -> Estimate | None:
    """The share of about so many pieces that the engine confirms, whether or not agents learn from those alone.

    ± is the binomial standard error. None where no two stretches match.
    """
    _, report = augmentation(parts, pieces, seed, matching, confirm=False)
    return _estimate(report) if report.tried else None


def _estimate(report: RecombinationReport) -> Estimate:
    share = report.share
    error = float(np.sqrt(share * (1.0 - share) / report.tried)) if report.tried > 1 else None
    return Estimate(share, error, report.tried)


def augmented_populations(episodes: Sequence[PathEpisode], seed: int, pieces: int) -> list[AugmentedPopulation]:
    """The population recombined for both agents and for a single one; `content` of its episodes are trajectories."""
    trajectories: list[Trajectory] = [replace(one.content, map=one.map) for one in episodes]
    parts = whole_parts(trajectories, imitated_seats(one.kinds for one in trajectories))
    found = []
    for name, matching in _MATCHINGS.items():
        paths: defaultdict[str, list[Floats]] = defaultdict(list)
        for of_map, path in recombined_paths(parts, len(trajectories), seed, matching):
            paths[of_map].append(path)
        found.append(AugmentedPopulation(name, dict(paths), valid_share(parts, pieces, seed, matching)))
    return found


RECOMBINATION = Recombination(trajectory_of, augmented_populations, _METHOD)
