"""Errors of agents, their training data and their checkpoints."""

from movingout.maps.errors import MovingOutError


class AgentError(MovingOutError):
    """An agent is unknown, cannot be made, or answers with something that is not an action chunk."""


class TooSlowError(AgentError):
    """On this machine an agent takes longer for a decision than a tick."""


class AgentsBusyError(MovingOutError):
    """The worker processes have no capacity left for another agent."""


class DataError(MovingOutError):
    """Training data or a training configuration cannot be used."""


class CheckpointError(AgentError):
    """A checkpoint is missing, damaged, too large, or contains something that is not allowed."""
