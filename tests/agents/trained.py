"""Trained agents from where a test has put them, as the catalogue loads those in the folders of models."""

from movingout.agents.base import Agent
from movingout.agents.checkpoint.checkpoint import Checkpoint
from movingout.agents.kinds.registry import kind_of


def load_checkpoint(checkpoint: Checkpoint, **options: object) -> Agent:
    """The agent of a checkpoint, its files verified. `options` are those of its kind, which checks them itself."""
    return kind_of(checkpoint.card).load(checkpoint, **options)
