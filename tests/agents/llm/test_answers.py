"""What is understood of a model's answer, and what is said of the rest."""

import pytest

from movingout.agents.decision_trace import MAX_PLAN
from movingout.agents.llm.answers import ModelAnswer, Skill, UselessAnswerError, read_answer

NONE: frozenset[int] = frozenset()


def read(text: str, delivered: frozenset[int] = NONE, heavy: frozenset[int] = NONE) -> ModelAnswer:
    return read_answer(text, 3, delivered, heavy)


@pytest.mark.parametrize(
    "text",
    [
        '{"plan": "I go.", "skills": [{"skill": "fetch", "item": 1}]}',
        'Sure!\n```json\n{"plan": "I go.", "skills": [{"skill": "fetch", "item": "1"}]}\n```',
        '<think>perhaps {"skill": "wait"}, or {this}</think>{"plan":" I\\n go. ","skill":"Fetch","item":1.0}',
        '{"plan": "I go.", "skills": {"skill": "fetch", "item": 1}} as {you} said',
    ],
)
def test_the_object_is_found_wherever_it_is(text: str) -> None:
    assert read(text) == ModelAnswer("I go.", (Skill("fetch", 1),))


def test_skills_come_in_turn_and_have_bounds() -> None:
    long = (
        '{"skills": ["help", "step aside", {"skill": "wait", "seconds": 99}, '
        '{"skill": "hand-over", "item": 2}, "wait", "wait"]}'
    )
    assert read(long, heavy=frozenset([2])).skills == (
        Skill("help"),
        Skill("step_aside"),
        Skill("wait", ticks=100),
        Skill("fetch", 2),
        Skill("wait", ticks=30),
    )


def test_what_cannot_be_done_is_left_out_with_its_reason() -> None:
    text = '{"skills": [{"skill": "fetch", "item": 7}, {"skill": "fetch", "item": 0}, {"skill": "dance"}, 4, "help"]}'
    assert read(text, frozenset([0])) == ModelAnswer(
        "",
        (Skill("help"),),
        ("there is no item 7", "item 0 is delivered", "there is no skill 'dance'", "'4' is no skill"),
    )


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "no JSON object"),
        ("I would fetch item 1.", "no JSON object"),
        ("[1, 2]", "no JSON object"),
        ('{"plan": "nothing"}', "no JSON object"),
        ('{"skills": []}', "names no skill"),
        ('{"skills": null}', "'None' is no skill"),
        ('{"skill": "fetch"}', "needs the number of an item"),
        ('{"skill": "fetch", "item": true}', "needs the number"),
        ('{"skill": "fetch", "item": -1}', "needs the number"),
        ('{"skill": "fetch", "item": 1e400}', "needs the number"),
        ('{"skill": "fetch", "item": NaN}', "needs the number"),
        ("{" * 5000, "no JSON object"),
        ('{"a":' * 3000 + "1" + "}" * 3000, "no JSON object"),
    ],
)
def test_rubbish_is_named(text: str, why: str) -> None:
    with pytest.raises(UselessAnswerError, match=why):
        read(text)


def test_a_plan_is_one_bounded_line_of_text() -> None:
    plan = read('{"plan": "' + "a\\u0007\\n" * 500 + '", "skill": "help"}').plan
    assert len(plan) == MAX_PLAN and plan.isprintable()
    assert read('{"plan": 7, "skill": "help"}').plan == ""
