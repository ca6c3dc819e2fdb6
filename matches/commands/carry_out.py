"""The steps of a table carried out: what is done is skipped, and each says which it is and how long it takes."""

import contextlib
import os
import sys
from collections.abc import Sequence
from contextlib import AbstractContextManager
from itertools import groupby
from pathlib import Path

from movingout.matches.callbacks import OnProgress, no_op
from movingout.matches.commands.progress import bar
from movingout.matches.paper.costs import span
from movingout.matches.paper.methods import TrainedId
from movingout.matches.paper.parallel_training import train_agents
from movingout.matches.paper.steps import PaperStep, seconds_in_all
from movingout.matches.paper.training import LOGS
from movingout.matches.paper.workspace import Workspace

SHORT_S = 10.0  # a training in a process of its own has to take longer than to start one, which reads all of torch


def carry_out(steps: Sequence[PaperStep], space: Workspace, where: str) -> None:
    """Carry out those that are not done; trainings several at a time. `where` is said before each.

    Raises MovingOutError for one that cannot be carried out.
    """
    numbered = [(f"{number}/{len(steps)}", step) for number, step in enumerate(steps, start=1)]
    for trains, some in groupby(numbered, key=lambda one: one[1].trains is not None):
        group = list(some)
        if trains and space.at_once > 1:
            group = _train(group, space, where)
        for number, step in group:
            if not step.is_done():
                _say(f"{where}step {number}: {step.about} (about {span(step.seconds)})")
                if note := step.note():
                    _say(note)
                _perform(step, space)


def _train(group: Sequence[tuple[str, PaperStep]], space: Workspace, where: str) -> list[tuple[str, PaperStep]]:
    """Train several agents at a time; the steps that are left, where there is but one, or all are short."""
    todo = {step.trains: (number, step) for number, step in group if step.trains and not step.is_done()}
    if len(todo) < 2 or all(step.seconds < SHORT_S for _, step in todo.values()):
        return list(todo.values())
    took = span(seconds_in_all([step for _, step in todo.values()], space))
    first, at_once = next(iter(todo.values()))[0], min(space.at_once, len(todo))
    _say(
        f"{where}step {first} and on: train {len(todo)} agents, {at_once} at a time (about {took}); what they print is "
        f"in {Path.cwd() / LOGS}"
    )
    with bar("agents") as progress:
        trained = 0

        def note(agent: TrainedId, seconds: float) -> None:
            nonlocal trained
            trained += 1
            number, step = todo[agent]
            space.note_time(step.about, seconds)
            _say(f"{where}step {number}: {agent.text} is trained")
            progress(trained, len(todo))

        progress(0, len(todo))
        train_agents(list(todo), space, note)
    return []


def _perform(step: PaperStep, space: Workspace) -> None:
    shown: AbstractContextManager[OnProgress] = (
        contextlib.nullcontext(no_op) if step.trains else bar(step.about.split()[0])
    )
    begun = _processor_seconds()
    try:
        with shown as progress:
            step.perform(progress)
    finally:
        space.note_time(step.about, _processor_seconds() - begun)


def _processor_seconds() -> float:
    """Of this process and of those of its workers that have ended."""
    return sum(os.times()[:4])


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)
