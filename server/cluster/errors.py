"""Errors of a cluster, as sentences for whoever runs it."""

from movingout.maps.errors import MovingOutError


class ClusterError(MovingOutError):
    """A cluster cannot do what was asked for."""


class DatabaseAway(ClusterError):
    """The database that the nodes share does not answer."""


class NodeEnds(ClusterError):
    """This node ends, and begins nothing any more: nobody is to look into it."""


class NodeRefused(ClusterError):
    """This node may not join the cluster as it was started."""
