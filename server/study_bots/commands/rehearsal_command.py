"""`movingout study simulate`: simulated participants go through a study, and its data are checked afterwards."""

import argparse
import asyncio
import json
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Any, NamedTuple

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from movingout.maps.commands.sentences import tell
from movingout.maps.files.terminal import printable_lines
from movingout.server.commands.orderly_end import ended_by_sigterm
from movingout.server.options import values_of
from movingout.server.study_bots.cohort import Cohort, progress, with_kills
from movingout.server.study_bots.data_check import StoredData, agent_faults, find_losses, read_stored
from movingout.server.study_bots.rehearsal_server import RehearsalServer
from movingout.server.study_bots.simulated_participant import ActivityLog
from movingout.server.study_bots.simulation_plan import SimulationPlan
from movingout.server.study_bots.study_client import SimulationError
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.definition import Study
from movingout.study.design.study_file import read_study

REFRESH_S = 0.2  # of the progress bar


class RehearsalResult(NamedTuple):
    """The outcome of a rehearsal; the last four fields are set where its data are on this machine."""

    logs: Sequence[ActivityLog]
    stored: StoredData | None = None
    lost: Sequence[str] = ()
    data: Path | None = None
    faults: Sequence[str] = ()  # of agents


def simulate(args: argparse.Namespace) -> int:
    """Run the command and return its exit code. Raises StudyError."""
    study = read_study(args.file)
    plan = _plan(args, study)
    data: Path = args.data or _new_folder(study)
    try:
        if args.url:
            done = RehearsalResult(_watched(Cohort(args.url.rstrip("/"), plan)))
        else:
            done = rehearse(args.file, plan, data, args.kills)
    except KeyboardInterrupt:
        where = f"on the server at {args.url}" if args.url else f"in {data}; another rehearsal needs a new folder"
        tell(f"stopped; what was played until then stays {where}")
        return 130
    _say(args, done)
    return 1 if done.lost or done.faults else 0


def rehearse(file: Path, plan: SimulationPlan, data: Path, kills: int = 0) -> RehearsalResult:
    """Run a rehearsal on a server of its own and compare its data with the logs. Raises SimulationError."""
    folder = StudyFolder(read_study(file), data)
    if folder.own.exists():
        raise SimulationError(f"{folder.own} exists already; a rehearsal needs a new folder: --data DIR")
    with ended_by_sigterm(), RehearsalServer(file, data, plan.speed, plan.slow_agents) as server:
        logs = _watched(Cohort(server.address.base, plan), kills, server)
    stored = read_stored(folder)
    return RehearsalResult(logs, stored, find_losses(folder, stored, logs), data, agent_faults(folder, stored))


def _new_folder(study: Study) -> Path:
    return Path("data") / "simulated" / f"{study.id}-{datetime.now():%Y%m%d-%H%M%S}"


def _plan(args: argparse.Namespace, study: Study) -> SimulationPlan:
    people: int = study.participants if args.participants is None else args.participants
    if people < 1 or people % study.group:
        raise SimulationError(f"--participants must be {'even' if study.group == 2 else 'at least 1'}, not {people}")
    known = {"participants": people, "run": f"{datetime.now():%H%M%S}", "group": study.group}
    plan = SimulationPlan(**{**values_of(args, SimulationPlan), **known})
    if args.url and plan.slow_agents:
        raise SimulationError("--slow-agents goes to the server at --url: study serve --rehearse 1 --slow-agents")
    return replace(plan, at_once=max(plan.at_once, study.group))


def _watched(cohort: Cohort, kills: int = 0, server: RehearsalServer | None = None) -> Sequence[ActivityLog]:
    """Let everybody take part, with a progress bar on standard error."""

    def restart() -> None:
        assert server is not None
        server.kill()
        server.start()

    async def take_part() -> Sequence[ActivityLog]:
        with _bar() as bar:
            task = bar.add_task("", total=1.0, words=_words(cohort))
            taking_part = asyncio.create_task(with_kills(cohort, kills, restart))
            while not (await asyncio.wait([taking_part], timeout=REFRESH_S))[0]:
                bar.update(task, completed=progress(cohort), words=_words(cohort))
            bar.update(task, completed=progress(cohort), words=_words(cohort))
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


def _words(cohort: Cohort) -> str:
    finished = sum(bool(log.codes) for log in cohort.logs)
    rounds = sum(len(log.rounds) for log in cohort.logs) // cohort.plan.group
    return f"{finished} of {cohort.plan.participants} finished, {rounds} rounds"


def _say(args: argparse.Namespace, done: RehearsalResult) -> None:
    console = Console(highlight=False, markup=False, soft_wrap=True)
    counts = _counts(done)
    if args.json:
        document = {"data": str(done.data) if done.data else None, **counts}
        document |= {"lost": list(done.lost), "faults": list(done.faults)}
        console.print(json.dumps(document, indent=2))
        return
    table = Table(box=None, pad_edge=False, show_header=False)
    for name, value in counts.items():
        shown = (
            ", ".join(f"{count} {_ENDINGS.get(word, word)}" for word, count in value.items())
            if isinstance(value, dict)
            else str(value)
        )
        table.add_row(name, shown)
    console.print(table)
    for sentence in done.lost:
        console.print(printable_lines(f"lost: {sentence}"))
    for sentence in done.faults:
        console.print(printable_lines(f"an agent had a fault {sentence}"))
    if done.data is not None:
        if not done.lost:
            console.print("Nothing is missing: everything the participants did and were shown is in the data.")
        console.print(f"The data are in {done.data}, marked as simulated. Next:")
        for action in ("report", "export"):
            console.print(f"  movingout study {action} {args.file} --data {done.data}")


_ENDINGS = {"delivered": "with everything delivered", "time": "until time was up", "done": "finished"}


def _counts(done: RehearsalResult) -> dict[str, Any]:
    counts: dict[str, Any] = {
        "participants": len(done.logs),
        "outcomes": dict(Counter(log.outcome for log in done.logs)),
        "codes": sum(len(log.codes) for log in done.logs),
        "clicks": sum(len(log.saved_answers) for log in done.logs),
    }
    if done.stored is not None:
        counts["rounds"] = dict(Counter(row["outcome"] or "open" for row in done.stored.rounds))
        counts["answers"] = len(done.stored.answers)
    return counts
