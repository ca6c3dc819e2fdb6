"""`movingout paper … --dry-run`: what is left to do and how long it takes, or why it cannot be done."""

import json
from collections.abc import Sequence

from movingout.maps.commands.sentences import tell
from movingout.maps.errors import MovingOutError
from movingout.maps.suggestion import counted
from movingout.matches.paper.beginning import check_beginning
from movingout.matches.paper.costs import span
from movingout.matches.paper.entry import PaperEntry
from movingout.matches.paper.steps import PaperStep, paper_steps, seconds_in_all
from movingout.matches.paper.workspace import Workspace


def dry_run(entries: Sequence[PaperEntry], space: Workspace, as_json: bool) -> int:
    """Print it; 1 where some of the labels would not be made. Raises MovingOutError where the only one would not."""
    check_beginning(space)
    refused = _refused(entries, space)
    if refused and len(entries) == 1:
        raise next(iter(refused.values()))
    steps = paper_steps([entry for entry in entries if entry.label not in refused], space)
    todo = [step for step in steps if not step.is_done()]
    seconds = seconds_in_all(todo, space)
    if as_json:
        _print_json(todo, seconds, len(steps) - len(todo), {label: str(error) for label, error in refused.items()})
        return 1 if refused else 0
    for label, error in refused.items():
        tell(f"{label} cannot be made: {error}")
    for step in todo:
        note = step.note()
        print(f"{span(step.seconds):>8}  {step.about}" + (f"; {note}" if note else ""))
    print(f"{counted(len(todo), 'step')} to do, {len(steps) - len(todo)} done; about {span(seconds)} in all, roughly")
    if space.budget.gpu:
        print("(trainings and decisions of the paper's networks as on an NVIDIA RTX A6000; on a CPU far longer)")
    return 1 if refused else 0


def _refused(entries: Sequence[PaperEntry], space: Workspace) -> dict[str, MovingOutError]:
    """By label, what would stop it. A step that several labels need is checked once."""
    found: dict[str, MovingOutError | None] = {}
    refused: dict[str, MovingOutError] = {}
    for entry in entries:
        for step in paper_steps([entry], space):
            if step.about not in found:
                found[step.about] = _problem(step)
            if (error := found[step.about]) is not None:
                refused.setdefault(entry.label, error)
    return refused


def _problem(step: PaperStep) -> MovingOutError | None:
    try:
        if step.check is not None and not step.is_done():
            step.check()
    except MovingOutError as error:
        return error
    return None


def _print_json(todo: Sequence[PaperStep], seconds: float, done: int, refused: dict[str, str]) -> None:
    document = {
        "steps": [{"step": step.about, "estimated_s": step.seconds} for step in todo],
        "finished": done,
        "estimated_s": seconds,
        "not_made": refused,
    }
    print(json.dumps(document, indent=2))
