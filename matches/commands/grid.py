"""`movingout match grid GRID.yaml`: play a grid into a results folder, or estimate how long that takes."""

import argparse
import json
import os
import sys
import time
from contextlib import redirect_stdout
from dataclasses import replace
from pathlib import Path
from typing import Any

from movingout.agents.base import Agent
from movingout.agents.catalogue import load_agent
from movingout.maps.commands.parser import add_out
from movingout.maps.commands.sentences import tell
from movingout.maps.files.terminal import printable, printable_lines
from movingout.maps.suggestion import counted
from movingout.matches.commands.progress import bar
from movingout.matches.commands.worker_options import add_workers, worker_pool_of, workers_of
from movingout.matches.errors import MatchError
from movingout.matches.execution.lockstep import Lockstep
from movingout.matches.experiment.grid import Grid, read_grid
from movingout.matches.experiment.held_out import held_out_cautions
from movingout.matches.experiment.plan import matches_of, missing_agents, planned_matches
from movingout.matches.experiment.shared_labels import shared_label_cautions
from movingout.matches.experiment.shipped_grids import grid_path, shipped_grids
from movingout.matches.grid_run import GridRun, played_again, played_unrecorded, run_grid
from movingout.matches.preparation import check_own_maps, check_variants
from movingout.matches.report.html_page import write_page
from movingout.matches.report.parquet import write_parquet
from movingout.matches.results.other_code import MIXED, of_other_code, played_by_other_code
from movingout.matches.results.provenance import provenance_of
from movingout.matches.results.results_folder import GRID, open_folder, order_of, read_results, to_play
from movingout.matches.results.table import ALL_MAPS, markdown
from movingout.recordings.report.words import DEFAULT, LANGUAGES
from movingout.world.exactness import inexact_engine

_PROBES = 4  # matches played for an estimate
_PROBE_TICKS = 100
_DEVICE = "MOVINGOUT_DEVICE"  # as in `agents.inference.device`, which loads onnxruntime


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("grid", type=Path, metavar="GRID.yaml", help=f"a file, or one of {', '.join(shipped_grids())}")
    add_out(parser, "DIR", "results folder; default: data/matches/<grid>")
    add_workers(parser)
    parser.add_argument(
        "--shard", default="0/1", metavar="I/N", help="every N-th match from the I-th on, 0 to N-1 (%(default)s)"
    )
    parser.add_argument("--record", action="store_true", help="write each match as a recording into DIR/recordings")
    parser.add_argument("--html", action="store_true", help="also write DIR/results.html with the cross-play matrices")
    parser.add_argument("--language", choices=LANGUAGES, default=DEFAULT, help=f"language of the page ({DEFAULT})")
    parser.add_argument(
        "--dry-run",
        action="store_true",
        help="only say how many matches there are and how long they will take",
    )
    parser.add_argument("--json", action="store_true", help="one JSON document on standard output")
    parser.set_defaults(perform=perform)


def perform(args: argparse.Namespace) -> int:
    """Raises MatchError."""
    shard, path = _shard(args.shard), grid_path(args.grid)
    grid = read_grid(path)
    folder: Path = args.out or Path("data/matches") / path.stem
    pool = worker_pool_of(args)
    for sentence in (*shared_label_cautions(grid), *held_out_cautions(grid)):
        tell(sentence)
    if args.dry_run:
        return _dry_run(grid, folder, workers_of(args), args.json)
    if caution := inexact_engine():
        tell(caution)
    try:
        with bar("matches") as progress:
            run = run_grid(
                grid, folder, workers=workers_of(args), record=args.record, shard=shard, pool=pool,
                progress=progress, again=_say_again, unrecorded=_say_unrecorded, other_code=_say_other_code,
                caution=_say_caution,
            )  # fmt: skip
    except KeyboardInterrupt:
        tell(_stopped(folder))
        return 130
    notes = [write_parquet(run), MIXED if run.mixed_code else ""]
    if args.html:
        write_page(run, args.language)
    _show(run, args, [note for note in notes if note])
    return 0


def _stopped(folder: Path) -> str:
    """Whether there is anything to go on with, and how."""
    if not read_results(folder):
        return "stopped before a match was finished; run the same command again"
    return "stopped; finished matches are kept, run the same command again to continue"


def _say_caution(sentence: str) -> None:
    tell(sentence)


def _say_again(failed: int) -> None:
    tell(played_again(failed))


def _say_unrecorded(matches: int) -> None:
    tell(played_unrecorded(matches))


def _say_other_code(matches: int) -> None:
    tell(played_by_other_code(matches))


def _show(run: GridRun, args: argparse.Namespace, notes: list[str]) -> None:
    if args.json:
        print(json.dumps({**run.to_json(), "folder": str(run.folder), "notes": notes}, indent=2))
    else:
        rows = [row for row in run.rows if row.map == ALL_MAPS] or run.rows
        print(printable_lines(markdown(rows)))
        files = "results.html, " if args.html else ""
        by_map = ", by map" if len(rows) < len(run.rows) else ""
        print(f"{len(run.results)} matches in {run.folder}: {files}results.md{by_map}, results.json, results-*.jsonl")
    if run.missing:
        tell(f"{run.missing} matches of other shards are still missing")
    for result in run.failures[:5]:
        tell(f"{result.match.map}, seed {result.match.seed}: failed: {result.failure}")
    if len(run.failures) > 5:
        tell(f"and {len(run.failures) - 5} more failed matches, see results.json")
    for note in notes:
        tell(note)


def _dry_run(grid: Grid, folder: Path, workers: int, as_json: bool) -> int:
    missing = missing_agents(grid)
    if not missing and (folder / GRID).exists():
        open_folder(folder, grid, provenance_of(grid))  # refused as by the run itself
    matches = matches_of(planned_matches(grid, order_of(folder)))
    if not missing:
        check_own_maps(matches)
    finished = read_results(folder) if (folder / GRID).exists() else {}
    todo = to_play(matches, finished)
    check_variants(todo)
    failed = sum(match.id in finished for match in todo)
    if todo and (other := of_other_code(finished.values())):
        _say_other_code(other)
    seconds = None if missing else _seconds_per_match(grid) * len(todo) / workers if todo else 0.0
    document: dict[str, Any] = {
        "grid": grid.name, "matches": len(matches), "finished": len(matches) - len(todo), "to_play": len(todo),
        "failed": failed, "workers": workers, "estimated_s": seconds, "missing_agents": missing,
    }  # fmt: skip
    if as_json:
        print(json.dumps(document, indent=2))
        return 0
    print(f"{printable(grid.name)}: {len(matches)} matches, {len(matches) - len(todo)} finished, {len(todo)} to play")
    if failed:
        print(played_again(failed))
    if seconds:
        print(f"about {_span(seconds)} with {counted(workers, 'worker')} here, estimated from {_PROBES} short matches")
    for sentence in missing:
        print(printable(f"missing: {sentence}"))
    return 0


def _seconds_per_match(grid: Grid) -> float:
    """Seconds of a match of full length for one worker, estimated from a few short ones spread over the grid.

    They are seconds of the processor, which other programs on the machine do not change; by the clock where an agent
    `waits`, as for a server, or networks run on a GPU.
    """
    matches = matches_of(planned_matches(grid))
    step = max(len(matches) // _PROBES, 1)
    waits = os.environ.get(_DEVICE, "cpu") not in ("", "cpu")
    spent = passed = 0.0

    def load(agent_id: str) -> Agent:
        nonlocal waits
        agent = load_agent(agent_id)
        waits = waits or bool(getattr(agent, "waits", False))
        return agent

    lockstep = Lockstep(batch_size=1, load=load)
    probes = matches[::step][:_PROBES]
    for match in probes:
        ticks = min(match.ticks, _PROBE_TICKS)
        begun, at = time.process_time(), time.monotonic()
        with redirect_stdout(sys.stderr):  # what agents print is no part of the answer, as from worker processes
            list(lockstep.play([replace(match, ticks=ticks)]))
        spent += (time.process_time() - begun) * match.ticks / ticks
        passed += (time.monotonic() - at) * match.ticks / ticks
    return (passed if waits else spent) / len(probes)


def _span(seconds: float) -> str:
    if seconds < 90:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"


def _shard(text: str) -> tuple[int, int]:
    index, slash, count = text.partition("/")
    if not slash or not index.isdecimal() or not count.isdecimal() or int(index) >= int(count):
        raise MatchError(f"--shard is I/N with I from 0 to N-1, as in 0/4, not {text!r}")
    return int(index), int(count)
