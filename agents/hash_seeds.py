"""Whether an agent decides alike in processes with other seeds of `hash`, which Python draws anew for each process.

As a program it has the arguments AGENT MAP TICKS, and writes a hash of each decision.
"""

import json
import os
import subprocess
import sys
from contextlib import ExitStack, redirect_stdout
from hashlib import sha256
from itertools import zip_longest
from pathlib import Path

from movingout.agents.base import EpisodeInfo
from movingout.agents.catalogue import load_agent
from movingout.agents.conformance import SEED, TICKS, episode_answers
from movingout.agents.worker.parent_process import end_with_parent
from movingout.agents.worker.thread_budget import ONE_THREAD
from movingout.maps import MovingOutError, load_map

SEEDS = ("0", "1", "2")  # three, as two agree by chance where one bit of a hash decides


def process_problem(agent_id: str, the_map: str, ticks: int | None = None) -> str:
    """What is wrong where an agent plays an episode (a map's name or file) in several processes; "" for nothing."""
    command = [sys.executable, "-P", "-m", __name__, agent_id, the_map, str(ticks or TICKS)]
    paths = os.pathsep.join(path or str(Path.cwd()) for path in sys.path)
    with ExitStack() as stack:
        environments = [{**os.environ, **ONE_THREAD, "PYTHONPATH": paths, "PYTHONHASHSEED": seed} for seed in SEEDS]
        processes = [
            stack.enter_context(subprocess.Popen(command, env=one, stdout=subprocess.PIPE, stderr=subprocess.PIPE))
            for one in environments
        ]
        told = [process.communicate() for process in processes]
    for process, (_, errors) in zip(processes, told, strict=True):
        if process.returncode:
            last = errors.decode(errors="replace").strip().splitlines()[-1:]
            return f"in a process of its own it ended with {process.returncode}: {''.join(last)}"
    first, *others = [json.loads(output.splitlines()[-1]) for output, _ in told]
    return next((_difference(first, other, the_map) for other in others if other != first), "")


def _difference(one: list[str], other: list[str], the_map: str) -> str:
    number = next(number for number, (a, b) in enumerate(zip_longest(one, other), 1) if a != b)
    return (
        f"{load_map(the_map).name}, blue: decision {number} is another in another process, for the same map, seat and "
        "seed; an agent should use neither hash() of a text nor the order of a set, which change with each process "
        "(PYTHONHASHSEED)"
    )


def main(agent_id: str, the_map: str, ticks: str) -> None:
    """Write the hashes; threads that the agent has started do not keep the process."""
    end_with_parent()
    try:
        with redirect_stdout(sys.stderr):  # what the agent prints
            given = episode_answers(load_agent(agent_id), EpisodeInfo(load_map(the_map), 0, SEED, int(ticks)))
    except MovingOutError as error:
        sys.exit(f"movingout: {error}")
    sys.stdout.write(json.dumps([sha256(answer.tobytes()).hexdigest() for answer in given]) + "\n")
    sys.stdout.flush()
    os._exit(0)


if __name__ == "__main__":
    main(*sys.argv[1:])
