"""The limit of open files of this process: every socket and every journal is one."""

from movingout.server.settings import Limits

BESIDES = 200  # the program's own: modules, databases, pipes to other processes
MOST = 65_536


def raise_open_files(limits: Limits) -> str:
    """Raise the limit as far as the system allows; a sentence when that is too few for `limits`, else empty."""
    try:
        import resource
    except ImportError:  # a system without such a limit
        return ""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = MOST if hard == resource.RLIM_INFINITY else min(MOST, hard)
    if soft != resource.RLIM_INFINITY and soft < wanted:
        resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))
    needed = limits.sockets + limits.rooms + BESIDES
    if wanted >= needed:
        return ""
    return f"only {wanted} files may be open at once, {needed} may be needed; raise the limit: ulimit -n {needed}"
