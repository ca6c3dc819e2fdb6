"""A Ray cluster (extra `cluster`): connecting to one, and work shared among its processors.

Every node needs this package in the same version, and the files under the same path.
"""

import os
import socket
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from typing import Any, TypeVar

from movingout.maps.errors import MovingOutError
from movingout.maps.extras import needs_extra
from movingout.recordings.errors import RecordingError
from movingout.recordings.progress import with_progress

CONNECT_TIMEOUT_S = 5.0
AHEAD = 4  # values per processor that are on their way
T = TypeVar("T")
R = TypeVar("R")


class NoCluster(RecordingError):
    """No Ray cluster answers."""


def ray_module() -> Any:
    with needs_extra("cluster", "a Ray cluster"):
        import ray
    return ray


def connect(address: str) -> Any:
    """The module `ray`, connected: `auto` is the cluster that runs here. Raises NoCluster."""
    ray = ray_module()
    if not ray.is_initialized():
        os.environ.setdefault("RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO", "0")
        try:
            _check_reachable(address)
            ray.init(address=address, logging_level="ERROR", log_to_driver=False)
        except (OSError, ValueError, RuntimeError) as error:
            reason = (str(error).strip().splitlines() or [type(error).__name__])[0]
            raise NoCluster(
                f"no Ray cluster answers at {address!r} ({reason}); start one with: ray start --head"
            ) from error
    return ray


def processors() -> int:
    """Of the connected cluster."""
    return max(1, int(ray_module().cluster_resources().get("CPU", 1)))


def map_on_ray(address: str, function: Callable[[T], R], values: Sequence[T], verb: str) -> Iterator[R]:
    """The results in order with a progress bar, see `on_ray`."""
    yield from with_progress(on_ray(address, function, values), len(values), verb)


def on_ray(address: str, function: Callable[[T], R], values: Sequence[T]) -> Iterator[R]:
    """The results in order, computed on a cluster; what is lost with a node is done again.

    Raises NoCluster, and the MovingOutError that `function` raised.
    """
    ray = connect(address)
    task = ray.remote(num_cpus=1, max_retries=3, scheduling_strategy="SPREAD")(function)
    ahead, waiting = AHEAD * processors(), deque[Any]()
    for value in values:
        waiting.append(task.remote(value))
        if len(waiting) >= ahead:
            yield _result(ray, waiting.popleft())
    while waiting:
        yield _result(ray, waiting.popleft())


def _result(ray: Any, reference: Any) -> Any:
    try:
        return ray.get(reference)
    except ray.exceptions.RayError as error:
        if isinstance(cause := getattr(error, "cause", None), MovingOutError):
            raise cause from None
        first = str(error).strip().splitlines()[-1]
        raise NoCluster(f"the Ray cluster could not do it: {first[:300]}") from error


def _check_reachable(address: str) -> None:
    """Raise OSError when nothing listens at HOST:PORT; Ray itself would try for minutes."""
    host, _, port = address.rpartition("://")[2].rpartition(":")
    if host and port.isdecimal():
        socket.create_connection((host, int(port)), timeout=CONNECT_TIMEOUT_S).close()
