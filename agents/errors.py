"""What can go wrong with an agent."""

from movingout.maps.errors import MovingOutError


class AgentError(MovingOutError):
    """An agent is unknown, cannot be made, or answers with something that is not an action chunk."""


class AgentsBusyError(MovingOutError):
    """The worker processes have no time left for one more agent."""


class DataError(MovingOutError):
    """Recordings cannot be turned into training data."""


class CheckpointError(AgentError):
    """A checkpoint is missing, damaged, too large, or asks for something a checkpoint must not ask for."""
