"""A store as a run study leaves it: participants with answers and rounds, drawn from a seed."""

from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import numpy as np

from movingout.recordings import Event, SeatInfo, finalise
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.allocation import assign
from movingout.study.design.definition import Study
from movingout.study.design.steps import Step, steps
from movingout.study.design.study_file import parse_study
from movingout.study.design.templates import template_text
from movingout.study.store import Store, Unit
from movingout.study.store.frozen_study import freeze_study
from movingout.study.store.rounds import PlayerOutcome, RoundOutcome, Rounds
from tests.recordings.support import begin, play
from tests.study.support import OPENED, Clock

SHORT = {
    "    maps: [HandOff, PriorityPick, SingleRotation]": "    maps: [HandOff]"
}  # for `template`: studies of one map
SKILL = {"dp": 0.0, "bass": 0.25, "mlp": -0.1, "gru": -0.05}  # what a partner adds to the rate of completion


def template(name: str, **changes: str) -> tuple[Study, str]:
    """A template with some of its lines replaced, and its text."""
    text = template_text(name)
    for old, new in changes.items():
        text = text.replace(old, new)
    return parse_study(text, name), text


def fill(
    folder: Path,
    study: Study,
    text: str,
    people: int,
    *,
    seed: int = 0,
    recorded_ticks: int = 0,
    pings_of_people: int = 0,
    clock: Callable[[], int] | None = None,
) -> tuple[StudyFolder, Store, list[str]]:
    """A study in which so many took part; rounds have recordings where `recorded_ticks` is more than none.

    In each of them every person says `pings_of_people` pings, half of them at an item.
    """
    place = StudyFolder(study, folder)
    store = place.open(clock or Clock())
    OPENED.append(store)
    freeze_study(store, study.id, text, {"movingout": "test"}, {})
    random, pids = np.random.default_rng(seed), []
    with closing(place.open_identities()) as identities:
        for number in range(people):
            pid, _ = identities.pid("prolific", f"worker-{number:04d}")
            pids.append(pid)
    for first in range(0, people - people % study.group, study.group):
        _take_part(place, store, study, pids[first : first + study.group], random, (recorded_ticks, pings_of_people))
    return place, store, pids


def _take_part(
    place: StudyFolder,
    store: Store,
    study: Study,
    pids: list[str],
    random: np.random.Generator,
    recorded: tuple[int, int],
) -> None:
    for pid in pids:
        store.arrive(pid, "en")
        store.consent(pid, study.consent.version, "en", study.consent.text.text(), [])
    unit = store.form_unit(pids)
    taste = random.normal(0, 0.7, len(pids))
    for step in steps(study, assign(study, unit.slot)):
        if step.turn:
            _play(place, store, unit, step, random, recorded)
        if step.questionnaire:
            for pid, mood in zip(pids, taste, strict=True):
                _fill_in(store, study, pid, step, mood, random)
    for number, pid in enumerate(pids):
        store.finish(pid, "done", f"CODE-{unit.id}-{number}")


def _play(
    place: StudyFolder, store: Store, unit: Unit, step: Step, random: np.random.Generator, recorded: tuple[int, int]
) -> None:
    assert step.turn is not None
    episode = f"{place.study.id}-{unit.id}-{step.key.replace('/', '-')}"
    seated = [
        PlayerOutcome(pid, (step.turn.seat + member) % 2, "keyboard", 15.0 + member, 0.1, 0.0)
        for member, pid in enumerate(unit.pids)
    ]
    rounds = Rounds(store)
    rounds.begin(unit, step, episode, seated)
    tcr = float(np.clip(0.5 + SKILL.get(step.partner, 0.0) + random.normal(0, 0.2), 0, 1))
    outcome = "delivered" if tcr == 1.0 else "time"
    ticks, pings = recorded
    if ticks:
        seats = [SeatInfo("agent", step.partner), SeatInfo("agent", step.partner)]
        for one in seated:
            seats[one.seat] = SeatInfo("human", one.pid, device=one.device)
        writer, played = begin(
            place.recordings, map_name=step.turn.map, episode_id=episode, seats=tuple(seats),
            study={"study": place.study.id, "unit": str(unit.id), "step": step.key},
        )  # fmt: skip
        for number in range(pings):
            for one in seated:
                writer.event(Event(1, "ping", one.seat, item=number % 2 - 1))
        play(writer, played, ticks)
        finalise(writer.close("time"))
    consistency = 0.8 + float(random.normal(0, 0.05)) if random.random() < 0.9 else None
    rounds.end(episode, RoundOutcome(outcome, 500, tcr, tcr + 0.05, 5 * (1 - tcr), consistency, 1.5))


def _fill_in(store: Store, study: Study, pid: str, step: Step, mood: float, random: np.random.Generator) -> None:
    for item in study.questionnaire(step.questionnaire).items:
        text = f"It was {step.partner or 'fine'}." if item.kind == "text" else ""
        scale = item.allowed()
        value = -1
        if item.expected is not None:
            value = item.expected
        elif scale:
            centre = len(scale) * (0.5 + SKILL.get(step.partner, 0.0)) + mood
            value = int(np.clip(round(centre + random.normal(0, 1)), scale[0], scale[-1]))
        store.answer(pid, step.key, step.questionnaire, step.partner, item.id, value, text, 1000.0)
