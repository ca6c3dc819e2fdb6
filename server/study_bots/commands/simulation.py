"""A rehearsal from the command line: simulated participants take a study from the link to the code; all is checked."""

import argparse
import asyncio
import json
from collections import Counter
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from typing import Any, NamedTuple

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from movingout.server.study_bots.browser import SimulationError
from movingout.server.study_bots.crowd import Crowd, Plan, progress, with_kills
from movingout.server.study_bots.data_check import Kept, losses, read_kept
from movingout.server.study_bots.participant import Diary
from movingout.server.study_bots.rehearsal import RehearsalServer
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.definition import Study
from movingout.study.design.study_file import read_study

LOOK_S = 0.2  # between two looks at the progress


class Rehearsed(NamedTuple):
    """What came of a rehearsal; the last three are known where its data lie on this machine."""

    diaries: Sequence[Diary]
    kept: Kept | None = None
    lost: Sequence[str] = ()
    data: Path | None = None


def simulate(args: argparse.Namespace) -> int:
    """The exit code. Raises StudyError in a sentence."""
    study = read_study(args.file)
    plan = _plan(args, study)
    if args.url:
        done = Rehearsed(_watched(Crowd(args.url.rstrip("/"), plan)))
    else:
        done = rehearse(args.file, plan, args.data or _new_folder(study), args.kills)
    _say(args, done)
    return 1 if done.lost else 0


def rehearse(file: Path, plan: Plan, data: Path, kills: int = 0) -> Rehearsed:
    """Let everybody take part at a server of its own, and look for everything they did in its data."""
    folder = StudyFolder(read_study(file), data)
    if folder.own.exists():
        raise SimulationError(f"{folder.own} exists already; a rehearsal begins in a folder of its own: --data DIR")
    with RehearsalServer(file, data, plan.speed) as server:
        diaries = _watched(Crowd(server.served.base, plan), kills, server)
    kept = read_kept(folder)
    return Rehearsed(diaries, kept, losses(folder, kept, diaries), data)


def _new_folder(study: Study) -> Path:
    return Path("data") / "simulated" / f"{study.id}-{datetime.now():%Y%m%d-%H%M%S}"


def _plan(args: argparse.Namespace, study: Study) -> Plan:
    people: int = study.participants if args.participants is None else args.participants
    if people < 1 or people % study.group:
        raise SimulationError(f"--participants is {'even' if study.group == 2 else 'one or more'}, not {people}")
    at_once = max(args.at_once, study.group)
    return Plan(people, args.speed, args.seed, at_once, args.chaos, run=f"{datetime.now():%H%M%S}", group=study.group)


def _watched(crowd: Crowd, kills: int = 0, server: RehearsalServer | None = None) -> Sequence[Diary]:
    """Let everybody take part, with a bar on standard error."""

    def restart() -> None:
        assert server is not None
        server.kill()
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
    rounds = sum(len(diary.rounds) for diary in crowd.diaries) // crowd.plan.group
    return f"{finished} of {crowd.plan.participants} finished, {rounds} rounds"


def _say(args: argparse.Namespace, done: Rehearsed) -> None:
    console = Console(highlight=False, markup=False, soft_wrap=True)
    counts = _counts(done)
    if args.json:
        document = {"data": str(done.data) if done.data else None, **counts, "lost": list(done.lost)}
        console.print(json.dumps(document, indent=2))
        return
    table = Table(box=None, pad_edge=False, show_header=False)
    for name, value in counts.items():
        shown = ", ".join(f"{count} {word}" for word, count in value.items()) if isinstance(value, dict) else str(value)
        table.add_row(name, shown)
    console.print(table)
    for sentence in done.lost:
        console.print(f"lost: {sentence}")
    if done.data is not None:
        if not done.lost:
            console.print("Nothing is missing: the data hold what every participant did and was told.")
        console.print(f"These are simulated data, marked as such, in {done.data}. Next:")
        for action in ("report", "export"):
            console.print(f"  movingout study {action} {args.file} --data {done.data}")


def _counts(done: Rehearsed) -> dict[str, Any]:
    counts: dict[str, Any] = {
        "participants": len(done.diaries),
        "outcomes": dict(Counter(diary.outcome for diary in done.diaries)),
        "codes": sum(len(diary.codes) for diary in done.diaries),
        "clicks": sum(len(diary.clicks) for diary in done.diaries),
    }
    if done.kept is not None:
        counts["rounds"] = dict(Counter(row["outcome"] or "open" for row in done.kept.rounds))
        counts["answers"] = len(done.kept.answers)
    return counts
