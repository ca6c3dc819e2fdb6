"""`movingout recordings`: those of recordings/commands/recordings.py; `diversity` can recombine, as trainings do."""

import argparse
import importlib

from movingout.recordings.commands import recordings
from movingout.recordings.commands.recordings import run
from movingout.recordings.diversity.augmented import Recombination

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    recordings.configure(parser, _recombination)


def _recombination() -> Recombination:
    """Imported when it is asked for: what agents learn from takes a while to import."""
    found: Recombination = importlib.import_module("movingout.agents.training.recombined_paths").RECOMBINATION
    return found
