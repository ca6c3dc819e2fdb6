"""What a model answers: a JSON object with a plan and skills, wherever in its text; all else is refused."""

import json
from dataclasses import dataclass, replace
from typing import Any

from movingout.agents.decision_trace import MAX_PLAN
from movingout.world.constants import TICKS_PER_SECOND

ITEM_SKILLS = ("fetch", "hand_over")
SKILLS = (*ITEM_SKILLS, "help", "wait", "step_aside")
ALONE = "alone"  # the scripted agent's own choice; a fallback, never a model's
MOST_SKILLS = 5
MOST_OBJECTS = 200  # braces tried in one text
WAIT_S, LONGEST_S = 3.0, 10.0

INSTRUCTIONS = f"""You are one of two robots that carry all items into the goals together, seen from above.
Small items need one robot; heavy ones need both, at two ends.
You choose skills; they are carried out for you, one after the other, until you answer again.

Skills:
{{"skill": "fetch", "item": N}}      take item N to a goal; take one end of a heavy item and wait for your partner
{{"skill": "hand_over", "item": N}}  bring small item N to where your partner can take it, and put it down
{{"skill": "help"}}                  go to the heavy item that your partner holds, or to where it asks for help
{{"skill": "wait", "seconds": S}}    stay where you are, at most {LONGEST_S:g} s
{{"skill": "step_aside"}}            leave your partner's way

Answer with one JSON object and nothing else: a plain sentence that tells your partner your plan,
and 1 to {MOST_SKILLS} skills:
{{"plan": "I fetch the small box while you take the round one.", "skills": [{{"skill": "fetch", "item": 0}}]}}"""


class UselessAnswerError(Exception):
    """Nothing in the answer can be done."""


@dataclass(frozen=True, slots=True)
class Skill:
    """Something to do; `item` is -1 for none, `ticks` is for how long to wait."""

    name: str
    item: int = -1
    ticks: int = 0

    def __str__(self) -> str:
        return self.name if self.item < 0 else f"{self.name} {self.item}"


@dataclass(frozen=True, slots=True)
class ModelAnswer:
    """A plan in words, what to do in turn, and what was left out of it and why."""

    plan: str
    skills: tuple[Skill, ...]
    left_out: tuple[str, ...] = ()


def read_answer(text: str, items: int, delivered: frozenset[int], heavy: frozenset[int]) -> ModelAnswer:
    """The answer in a model's text, for a state with so many items. Raises UselessAnswerError."""
    told = _object(text)
    wanted = told.get("skills", [told] if "skill" in told else [])
    if not isinstance(wanted, list):
        wanted = [wanted]
    skills: list[Skill] = []
    left_out: list[str] = []
    for one in wanted[:MOST_SKILLS]:
        try:
            skills.append(_possible(_skill(one), items, delivered, heavy))
        except UselessAnswerError as error:
            left_out.append(str(error))
    if not skills:
        raise UselessAnswerError("; ".join(left_out) or "it names no skill")
    return ModelAnswer(_sentence(told.get("plan")), tuple(skills), tuple(left_out))


def _object(text: str) -> dict[str, Any]:
    """The last object with a skill: models like to think aloud before they answer."""
    decoder, found, at = json.JSONDecoder(), None, text.find("{")
    for _ in range(MOST_OBJECTS):
        if at < 0:
            break
        try:
            value, end = decoder.raw_decode(text, at)
        except (ValueError, RecursionError):
            end = at + 1
        else:
            found = value if "skills" in value or "skill" in value else found
        at = text.find("{", end)
    if found is None:
        raise UselessAnswerError("it has no JSON object with skills")
    return dict(found)


def _skill(told: object) -> Skill:
    told = {"skill": told} if isinstance(told, str) else told
    if not isinstance(told, dict) or not isinstance(told.get("skill"), str):
        raise UselessAnswerError(f"{str(told)[:40]!r} is no skill")
    name = "_".join(told["skill"].lower().replace("-", " ").replace("_", " ").split())
    if name not in SKILLS:
        raise UselessAnswerError(f"there is no skill {told['skill'][:40]!r}")
    if name == "wait":
        seconds = _number(told.get("seconds"), WAIT_S)
        return Skill(name, ticks=round(TICKS_PER_SECOND * min(max(seconds, 0.1), LONGEST_S)))
    if name not in ITEM_SKILLS:
        return Skill(name)
    item = _number(told.get("item"), -1.0)
    if item < 0 or not item.is_integer():
        raise UselessAnswerError(f"{name} needs the number of an item")
    return Skill(name, int(item))


def _possible(skill: Skill, items: int, delivered: frozenset[int], heavy: frozenset[int]) -> Skill:
    if skill.item >= items:
        raise UselessAnswerError(f"there is no item {skill.item}")
    if skill.item in delivered:
        raise UselessAnswerError(f"item {skill.item} is delivered")
    # nobody hands over what one robot cannot carry
    return replace(skill, name="fetch") if skill.name == "hand_over" and skill.item in heavy else skill


def _number(value: object, otherwise: float) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        return otherwise
    try:
        number = float(value)
    except (ValueError, OverflowError):
        return otherwise
    return number if abs(number) < 1e6 else otherwise


def _sentence(value: object) -> str:
    """One line of printable text."""
    text = " ".join(value.split()) if isinstance(value, str) else ""
    return "".join(letter for letter in text if letter.isprintable())[:MAX_PLAN]
