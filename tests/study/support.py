"""A small study with its store, and a clock that the test moves."""

from collections.abc import Sequence
from pathlib import Path

from movingout.study.design.allocation import assign
from movingout.study.design.definition import Study
from movingout.study.design.steps import Step, steps
from movingout.study.design.study_file import parse_study
from movingout.study.design.templates import template_text
from movingout.study.store import IdentityStore, Store
from movingout.study.store.frozen_study import freeze_study
from movingout.study.store.rounds import RoundOutcome

TEXT = template_text("agent_survey")
PLAYED = RoundOutcome("time", 500, 0.5, 0.6, 3.5, None, 1.25)
OPENED: list[Store | IdentityStore] = []  # closed after each test by tests/study/conftest.py


class Clock:
    """Milliseconds since the epoch; every look takes one."""

    def __init__(self) -> None:
        self.ms = 1_790_000_000_000

    def __call__(self) -> int:
        self.ms += 1
        return self.ms


def study() -> Study:
    return parse_study(TEXT)


def open_store(folder: Path | str, clock: Clock | None = None, text: str = TEXT) -> Store:
    """A store in which the study is frozen."""
    store = Store(folder / "study.sqlite" if isinstance(folder, Path) else folder, clock or Clock())
    OPENED.append(store)
    freeze_study(store, "agent-survey", text, {"movingout": "test"}, {"scripted": ""})
    return store


def open_identities(folder: Path | str) -> IdentityStore:
    identities = IdentityStore(folder / "identity.sqlite" if isinstance(folder, Path) else folder, Clock())
    OPENED.append(identities)
    return identities


def rounds_of(slot: int, of: Study | None = None) -> list[Step]:
    chosen = of or study()
    return [step for step in steps(chosen, assign(chosen, slot)) if step.turn]


def agree(store: Store, pids: Sequence[str], boxes: Sequence[str] = ("release",)) -> None:
    """Participants arrive and consent."""
    for pid in pids:
        store.arrive(pid, "en")
        store.consent(pid, "1", "en", "We record how you play.", boxes)
