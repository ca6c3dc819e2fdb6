"""Headless matches: one, a grid of them, on one machine or many."""

from matches.errors import MatchError
from matches.grid import Grid, read_grid
from matches.match import Match, MatchResult
from matches.run import GridRun, open_run, play, play_matches, run_grid

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
