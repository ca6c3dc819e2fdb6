"""The options that say where matches are played: in processes of this machine or on a Ray cluster."""

import argparse
import os

from movingout.matches.callbacks import WorkerPoolFactory
from movingout.matches.errors import MatchError
from movingout.matches.execution.local_workers import LocalWorkerPool
from movingout.matches.execution.ray_workers import cluster_processors, ray_worker_pool


def add_workers(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--workers", type=int, metavar="N", help="number of processes or actors; default: one per core")
    parser.add_argument("--ray", metavar="auto|ADDRESS", help="play on a Ray cluster instead (extra `cluster`)")


def worker_pool_of(args: argparse.Namespace) -> WorkerPoolFactory:
    """The factory of the chosen workers. Raises MatchError when no Ray cluster answers."""
    return LocalWorkerPool if args.ray is None else ray_worker_pool(args.ray)


def workers_of(args: argparse.Namespace) -> int:
    """How many workers to use. Call `worker_pool_of` first: it connects to the cluster whose processors count.

    Raises MatchError for fewer than 1.
    """
    if args.workers is not None and args.workers < 1:
        raise MatchError(f"--workers must be at least 1, not {args.workers}")
    return args.workers or (os.cpu_count() or 1 if args.ray is None else cluster_processors())
