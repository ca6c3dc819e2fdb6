"""The limit of open files of this process: every socket and every journal is one."""

import contextlib
from dataclasses import replace

from movingout.server.settings import Limits

BESIDES = 200  # the program's own: modules, databases, pipes to other processes
MOST = 65_536
OPEN_MAX = 10_240  # what macOS always allows
FEWEST = 0.25  # of the limit for connections, where it is so low that the rest would need it all
WEBSOCKETS = 0.75  # of the connections: pages are to be answered beside them


def raise_open_files(limits: Limits) -> str:
    """Raise the limit as far as the system allows; a sentence when that is too few for `limits`, else empty."""
    try:
        import resource
    except ImportError:  # a system without such a limit
        return ""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = MOST if hard == resource.RLIM_INFINITY else min(MOST, hard)
    if soft != resource.RLIM_INFINITY and soft < wanted:
        wanted = _raised(soft, wanted, hard)
    needed = limits.sockets + limits.connections_per_address + limits.rooms + BESIDES
    if wanted >= needed:
        return ""
    return f"only {wanted} files may be open at once, {needed} may be needed; raise the limit: ulimit -n {needed}"


def _raised(soft: int, wanted: int, hard: int) -> int:
    """The limit after raising it: macOS names no hard limit, but refuses more than it has."""
    import resource

    for limit in (wanted, OPEN_MAX):
        with contextlib.suppress(ValueError, OSError):
            if soft < limit <= wanted:
                resource.setrlimit(resource.RLIMIT_NOFILE, (limit, hard))
                return limit
    return soft


def most_connections(limits: Limits) -> int:
    """How many this process may have: the rest of its files are for journals, agents and databases."""
    try:
        import resource
    except ImportError:
        return MOST
    soft, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    files = MOST if soft == resource.RLIM_INFINITY else soft
    return max(int(FEWEST * files), files - limits.rooms - BESIDES)


def within_open_files(limits: Limits) -> Limits:
    """With no more websockets than this process can have."""
    return replace(limits, sockets=min(limits.sockets, int(WEBSOCKETS * most_connections(limits))))
