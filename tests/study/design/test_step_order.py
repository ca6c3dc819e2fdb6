"""From step to step, also when the time of a block is over."""

from movingout.study.design.allocation import assign
from movingout.study.design.step_order import LAST_SOLO_STEP, blocks_over, next_step
from movingout.study.design.steps import steps
from movingout.study.design.study_file import parse_study
from movingout.study.design.templates import template_text

LIMIT_MINUTES = 10.0
_PLAIN = parse_study(template_text("agent_survey"))
STUDY = _PLAIN.model_copy(
    update={"blocks": tuple(block.model_copy(update={"limit_minutes": LIMIT_MINUTES}) for block in _PLAIN.blocks)}
)
ORDER = steps(STUDY, assign(STUDY, 0))
BLOCK = STUDY.blocks[0].id
ROUNDS = [step.key for step in ORDER if step.kind == "round"]


def walk(key: str, over: set[str], played: set[str]) -> list[str]:
    """The kinds of all steps from `key` on."""
    kinds: list[str] = []
    while key != ORDER[-1].key:
        step = next_step(ORDER, key, over, played)
        kinds.append(step.kind)
        key = step.key
    return kinds


def test_with_time_left_every_step_follows() -> None:
    assert [step.kind for step in ORDER[1:]] == walk(ORDER[0].key, set(), set())


def test_a_block_whose_time_is_up_leaves_questions_about_what_was_played() -> None:
    kinds = walk(ROUNDS[0], {BLOCK}, {ROUNDS[0]})
    assert "round" not in kinds
    whole = walk(ROUNDS[0], set(), set())
    assert kinds == [kind for kind in whole if kind != "round" and kind != "break"]


def test_nobody_is_asked_about_a_partner_whom_they_never_met() -> None:
    after = [step.key for step in ORDER].index(LAST_SOLO_STEP) + 1
    assert walk(LAST_SOLO_STEP, {BLOCK}, set()) == [step.kind for step in ORDER[after:] if not step.block]


def test_a_round_that_cannot_be_played_takes_the_questions_about_it_along() -> None:
    text = template_text("agent_survey").replace(
        "    after_partner:", "    after_round: [nasa-tlx]\n    after_partner:"
    )
    order = steps(parse_study(text), assign(parse_study(text), 0))
    first, second, *_, last = [step.key for step in order if step.kind == "round"]
    about_partner = f"{first.rpartition('/')[0]}/movingout-paper-nine"
    assert next_step(order, first).key == f"{first}/nasa-tlx"
    assert next_step(order, first, unplayable=True).key == second
    assert next_step(order, last, played=[first], unplayable=True).key == about_partner
    assert next_step(order, last, unplayable=True).key == "debrief", "nobody is asked about whom they never met"


def test_what_is_asked_at_the_end_is_about_no_round_whatever_the_block_is_called() -> None:
    text = template_text("agent_survey").replace("  - id: play\n", "  - id: end\n") + "at_end: [nasa-tlx]\n"
    order = steps(parse_study(text), assign(parse_study(text), 0))
    last = [step.key for step in order if step.kind == "round"][-1]
    assert last.startswith("end/") and next_step(order, last, unplayable=True).key == "end/nasa-tlx"


def test_a_block_is_over_when_it_has_lasted_as_long_as_it_may() -> None:
    assert blocks_over(STUDY, {BLOCK: LIMIT_MINUTES * 60 - 1}) == frozenset()
    assert blocks_over(STUDY, {BLOCK: LIMIT_MINUTES * 60}) == {BLOCK}
    assert blocks_over(_PLAIN, {BLOCK: 1e9}) == frozenset()
