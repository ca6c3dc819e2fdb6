"""`movingout study simulate`: simulated participants take a study from the link to the code, and all is checked."""

import argparse
import asyncio
import json
import sys
from collections import Counter
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from server.study_bots.browser import SimulationError
from server.study_bots.checking import Kept, losses, read_kept
from server.study_bots.crowd import Crowd, Plan, progress, with_kills
from server.study_bots.participant import Diary
from server.study_bots.rehearsal import RehearsalServer
from study.definition import Study
from study.folder import StudyFolder
from study.study_file import read_study

MAX_SPEED = 20.0  # a tick of 5 ms: beyond it the server is busy all the time
LOOK_S = 0.2  # between two looks at the progress


def configure(commands: Any) -> None:
    """Add `simulate` to the sub-commands of `movingout study`."""
    simulate = commands.add_parser(
        "simulate",
        help="let simulated participants take the whole study, checked and marked as simulated; exit code 1 for a loss",
    )
    add = simulate.add_argument
    add("file", type=Path, metavar="FILE", help="the study file")
    add("--participants", type=int, metavar="N", help="how many (default: as many as the study wants)")
    add("--speed", type=_speed, default=1.0, metavar="N|max", help="times as fast as people (default: 1)")
    add("--data", type=Path, metavar="DIR", help="a new folder (default: data/simulated/ID-TIME)")
    add("--seed", type=int, default=0, help="of the answers, the people at the stick and the faults")
    add("--at-once", type=int, default=16, metavar="N", help="participants at the same time (%(default)s)")
    add(
        "--chaos",
        action="store_true",
        help="with reloads, broken connections, double clicks, absences and some who stop",
    )
    add("--kills", type=int, default=0, metavar="N", help="kill -9 the server so often, and start it again")
    add("--url", default="", help="a running server, started with `serve --rehearse`; without it one is started")
    add("--json", action="store_true", help="one JSON document on standard output")
    simulate.set_defaults(perform=run)


def run(args: argparse.Namespace) -> int:
    study = read_study(args.file)
    plan = _plan(args, study)
    if args.url:
        _say(args, study, _watched(Crowd(args.url.rstrip("/"), plan)), None, [])
        return 0
    data: Path = args.data or Path("data") / "simulated" / f"{study.id}-{datetime.now():%Y%m%d-%H%M%S}"
    folder = StudyFolder(study, data)
    if folder.own.exists():
        raise SimulationError(f"{folder.own} exists already; a rehearsal begins in a folder of its own: --data DIR")
    with RehearsalServer(args.file, data, args.speed) as server:
        diaries = _watched(Crowd(server.served.base, plan), args.kills, server)
    kept = read_kept(folder)
    lost = losses(folder, kept, diaries)
    _say(args, study, diaries, kept, lost, data)
    return 1 if lost else 0


def _plan(args: argparse.Namespace, study: Study) -> Plan:
    people: int = study.participants if args.participants is None else args.participants
    if people < 1 or people % study.group:
        raise SimulationError(f"--participants is {'even' if study.group == 2 else 'one or more'}, not {people}")
    at_once = max(args.at_once, study.group)
    return Plan(people, args.speed, args.seed, at_once, args.chaos, run=datetime.now().strftime("%H%M%S"))


def _watched(crowd: Crowd, kills: int = 0, server: RehearsalServer | None = None) -> Sequence[Diary]:
    """Let everybody take part, with a bar on standard error."""

    def restart() -> None:
        assert server is not None
        server.kill()
        print("the server was killed, and is started again", file=sys.stderr)
        server.start()

    async def take_part() -> Sequence[Diary]:
        with _bar() as bar:
            task = bar.add_task("", total=1.0, words=_words(crowd))
            taking_part = asyncio.create_task(with_kills(crowd, kills, restart))
            while not (await asyncio.wait([taking_part], timeout=LOOK_S))[0]:
                bar.update(task, completed=progress(crowd), words=_words(crowd))
            bar.update(task, completed=progress(crowd), words=_words(crowd))
            return await taking_part

    return asyncio.run(take_part())


def _bar() -> Progress:
    columns = (
        BarColumn(),
        TextColumn("{task.percentage:>3.0f}%"),
        TimeElapsedColumn(),
        TextColumn("{task.fields[words]}"),
    )
    return Progress(*columns, console=Console(stderr=True))


def _words(crowd: Crowd) -> str:
    finished = sum(bool(diary.codes) for diary in crowd.diaries)
    rounds = sum(len(diary.rounds) for diary in crowd.diaries)
    return f"{finished} of {crowd.plan.participants} participants have their code, {rounds} rounds seen to the end"


def _say(
    args: argparse.Namespace,
    study: Study,
    diaries: Sequence[Diary],
    kept: Kept | None,
    lost: Sequence[str],
    data: Path | None = None,
) -> None:
    counts = _counts(diaries, kept)
    if args.json:
        print(
            json.dumps({"study": study.id, "data": str(data) if data else None, **counts, "lost": list(lost)}, indent=2)
        )
        return
    table = Table(box=None, pad_edge=False, show_header=False)
    for name, value in counts.items():
        shown = ", ".join(f"{count} {word}" for word, count in value.items()) if isinstance(value, dict) else str(value)
        table.add_row(name, shown)
    Console(highlight=False).print(table)
    for sentence in lost:
        print(f"lost: {sentence}")
    if data is not None:
        print("nothing was lost: the store and the recordings hold what every participant did" if not lost else "")
        print(f"simulated data, marked as such, in {data}; next:")
        for action in ("report", "export"):
            print(f"  movingout study {action} {args.file} --data {data}")


def _counts(diaries: Sequence[Diary], kept: Kept | None) -> dict[str, Any]:
    counts: dict[str, Any] = {
        "participants": len(diaries),
        "outcomes": dict(Counter(diary.outcome for diary in diaries)),
        "codes": sum(len(diary.codes) for diary in diaries),
        "clicks": sum(len(diary.clicks) for diary in diaries),
    }
    if kept is not None:
        counts["rounds"] = dict(Counter(row["outcome"] or "open" for row in kept.rounds))
        counts["answers"] = len(kept.answers)
    return counts


def _speed(text: str) -> float:
    speed = MAX_SPEED if text == "max" else float(text)
    if not 0.1 <= speed <= MAX_SPEED:
        raise argparse.ArgumentTypeError(f"a speed is from 0.1 to {MAX_SPEED:g}, or max")
    return speed
