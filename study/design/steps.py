"""The steps of a participant through a study, each with a key that never changes.

The store keeps the key: after a reload or a restart of the server, a participant continues at the step whose key was
written last.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

from movingout.study.design.allocation import Assignment, Turn
from movingout.study.design.definition import SUBSTITUTE, Study
from movingout.study.design.sections.rounds import Block
from movingout.study.questionnaire import QuestionnaireItem
from movingout.world.constants import TICK_SECONDS

StepKind = Literal[
    "consent", "form", "input-check", "practice", "round", "questionnaire", "break", "debrief", "code"
]  # fmt: skip
CONSENT_S, INPUT_CHECK_S, DEBRIEF_S, CODE_S, BREAK_S = 180.0, 60.0, 60.0, 15.0, 120.0
TUTORIAL_S = 90.0
CARD_S = 10.0  # map card, both ready, countdown
SCALE_S, TEXT_S = 8.0, 45.0  # per question
"""Planned durations of steps that have no limit; assumed by `check`, not measured."""
AT_END = "end/"  # begins the key of a questionnaire that is asked after all blocks


@dataclass(frozen=True, slots=True)
class Step:
    """One screen, or one round."""

    key: str
    kind: StepKind
    seconds: float  # at most for rounds and practice, else as planned; none where the time of the block is up before
    block: str = ""
    partner: str = ""  # the id; screens show allocation.letters
    turn: Turn | None = None
    limit_ticks: int = 0
    questionnaire: str = ""


def steps(study: Study, assignment: Assignment) -> tuple[Step, ...]:
    """All steps of a slot in their order, from consent to completion code."""
    return tuple(_steps(study, assignment))


def partner_met(step: Step, members: int) -> str:
    """The partner of a step in data, with so many participants in the unit; "" for another participant, or nobody."""
    return step.partner or (SUBSTITUTE if step.block and members == 1 else "")


def planned_seconds(order: tuple[Step, ...]) -> float:
    return sum(step.seconds for step in order)


def _steps(study: Study, assignment: Assignment) -> Iterator[Step]:
    blocks = {block.id: block for block in study.blocks}
    yield Step("consent", "consent", CONSENT_S)
    if study.demographics:
        yield _questions(study, "form", "form", study.demographics)
    yield Step("input-check", "input-check", INPUT_CHECK_S)
    if study.practice:
        limit_ticks = study.practice.limit_ticks
        seconds = TUTORIAL_S if study.practice.tutorial else limit_ticks * TICK_SECONDS
        yield Step("practice", "practice", seconds, limit_ticks=limit_ticks)
    left = {block.id: _TimeLeft(block) for block in study.blocks}
    for number, visit in enumerate(assignment.visits):
        block = blocks[visit.block]
        yield from _visit(study, block, f"{block.id}/{number + 1}", visit.partner, visit.turns, left[block.id])
    for name in study.at_end:
        yield _questions(study, f"{AT_END}{name}", "questionnaire", name)
    if study.debrief:
        yield Step("debrief", "debrief", DEBRIEF_S)
    yield Step("code", "code", CODE_S)


class _TimeLeft:
    """How long a block may still last, with all its partners and what lies between the rounds."""

    def __init__(self, block: Block) -> None:
        self.seconds = block.limit_minutes * 60 if block.limit_minutes else float("inf")

    def take(self, seconds: float) -> float:
        """What is left of so many seconds."""
        taken = min(seconds, self.seconds)
        self.seconds -= taken
        return taken


def _visit(
    study: Study, block: Block, prefix: str, partner: str, turns: tuple[Turn, ...], left: _TimeLeft
) -> Iterator[Step]:
    maps_done, met = 0, left.seconds > 0
    for index, turn in enumerate(turns):
        new_map = index > 0 and turns[index - 1].map != turn.map
        maps_done += new_map
        if new_map and block.break_after_maps and maps_done % block.break_after_maps == 0:
            yield Step(f"{prefix}/break-{maps_done}", "break", left.take(BREAK_S), block.id, partner)
        planned = left.take(longest_round_s(block))
        key = f"{prefix}/{turn.map}-{turn.number}"
        yield Step(key, "round", planned, block.id, partner, turn, block.limit_ticks)
        for name in block.after_round:
            yield _asked(
                _questions(study, f"{key}/{name}", "questionnaire", name, block.id, partner), planned > 0, left
            )
    for name in block.after_partner:
        yield _asked(_questions(study, f"{prefix}/{name}", "questionnaire", name, block.id, partner), met, left)


def longest_round_s(block: Block) -> float:
    """A round of the block at most, with its map card."""
    return block.limit_ticks * TICK_SECONDS + CARD_S


def _asked(step: Step, met: bool, left: _TimeLeft) -> Step:
    """Questions about a round or a partner: all of them where these are met, else none."""
    left.take(step.seconds if met else 0.0)
    return step if met else replace(step, seconds=0.0)


def _questions(study: Study, key: str, kind: StepKind, name: str, block: str = "", partner: str = "") -> Step:
    seconds = sum(_item_seconds(item) for item in study.questionnaire(name).items)
    return Step(key, kind, seconds, block, partner, questionnaire=name)


def _item_seconds(item: QuestionnaireItem) -> float:
    return TEXT_S if item.is_text else SCALE_S
