"""A soak: players who come, drop, come back and leave at random beside floods, while room processes are killed.

Options: `--minutes M` (5), `--players N` (30), `--processes N` (2), `--kill-every S` (60), `--kills-for M` (a quarter
of the time, after which memory is watched), `--seed N`. Prints what happened, the memory and the open files of all
processes of the server, and whatever was lost.
"""

import argparse
import asyncio
import tempfile
from pathlib import Path
from random import Random

from tests.attacks.soak import Soak, Tally, faults_of, server_at, wait_for_recordings

WARM_UP = 0.25  # of the time, which the slope of the memory leaves out
KILLING = 0.25  # of the time: a process that has just begun hides what the one before has leaked


def main(options: list[str]) -> None:
    parser = argparse.ArgumentParser(prog="python -m bench soak", description=__doc__)
    parser.add_argument("--minutes", type=float, default=5.0)
    parser.add_argument("--players", type=int, default=30)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--kill-every", type=float, default=60.0, metavar="S")
    parser.add_argument("--kills-for", type=float, metavar="M")
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args(options)
    seconds = 60.0 * args.minutes
    kills_for_s = KILLING * seconds if args.kills_for is None else 60.0 * args.kills_for
    with tempfile.TemporaryDirectory(prefix="movingout-soak-") as folder:
        data = Path(folder) / "data"
        data.mkdir()
        with server_at(data, args.processes) as (base, token, process):
            soak = Soak(base, token, process, Random(args.seed))
            tally = asyncio.run(soak.run(args.players, seconds, args.kill_every, kills_for_s))
            wait_for_recordings(data / "recordings")
        faults, recordings = faults_of(data / "recordings"), len(list((data / "recordings").glob("*.mcap")))
    _tell(tally, faults, recordings)


def _tell(tally: Tally, faults: list[str], recordings: int) -> None:
    ended = f"{tally.rounds} rounds over, {tally.drops} drops, {tally.leaves} left"
    print(f"{ended}, {tally.kills} kills, {tally.floods} floods")
    print(f"seats lost: {len(tally.lost)} {tally.lost[:5]}")
    print(f"recordings: {recordings}, of which faulty: {len(faults)} {faults[:5]}")
    kept = slice(int(WARM_UP * len(tally.rss_mb)), None)
    slope = 10 * tally.mb_per_minute(tally.at_s[kept][0])
    print(
        f"memory of all processes: {tally.rss_mb[kept][0]:.0f} to {tally.rss_mb[-1]:.0f} MB, {slope:+.1f} MB per 10 min"
    )
    print(f"open files: {min(tally.open_files[kept])} to {max(tally.open_files[kept])}")
