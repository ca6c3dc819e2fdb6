"""Many independent calls, such as episodes to play: here, in processes of this machine, or on a Ray cluster."""

import os
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import as_completed
from contextlib import redirect_stdout
from pathlib import Path
from typing import TypeVar

from movingout.agents.checkpoint.checkpoint import MODELS_VARIABLE, own_models
from movingout.recordings.process_pool import process_pool
from movingout.recordings.ray_cluster import on_ray

R = TypeVar("R")


def results_of(calls: Sequence[Callable[[], R]], workers: int, ray: str = "") -> Iterator[R]:
    """What the calls return, as they finish: from `workers` processes, or from the Ray cluster at an address.

    On a cluster, paths in calls are absolute and all nodes see them. Raises what a call raised, and NoCluster.
    """
    if ray:
        paths, models = [path or str(Path.cwd()) for path in sys.path], own_models()

        def there(call: Callable[[], R]) -> R:
            return _there(paths, models, call)

        yield from on_ray(ray, there, calls)
    elif workers == 1:
        yield from map(_here, calls)
    else:
        with process_pool(workers) as processes:
            for future in as_completed([processes.submit(call) for call in calls]):
                yield future.result()


def _here(call: Callable[[], R]) -> R:
    """In this process; what agents print goes to standard error, as from worker processes."""
    with redirect_stdout(sys.stderr):
        return call()


def _there(paths: list[str], models: str, call: Callable[[], R]) -> R:
    """In a process of another machine, with this one's modules and trained agents."""
    sys.path += [path for path in paths if path not in sys.path]
    os.environ[MODELS_VARIABLE] = models
    return call()
