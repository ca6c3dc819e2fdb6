"""Headless matches: single ones and grids of them, on one machine or many."""

from movingout.matches.errors import MatchError
from movingout.matches.experiment.grid import Grid, read_grid
from movingout.matches.grid_run import GridRun, open_run, run_grid
from movingout.matches.match import Match, MatchResult
from movingout.matches.run import play, play_matches

__all__ = [
    "Grid",
    "GridRun",
    "Match",
    "MatchError",
    "MatchResult",
    "open_run",
    "play",
    "play_matches",
    "read_grid",
    "run_grid",
]
