"""The rated questions of a study, and when each is asked."""

from collections import defaultdict
from collections.abc import Iterator
from typing import Final, Literal, NamedTuple

from movingout.study.design.definition import Study
from movingout.study.design.localized_text import DEFAULT
from movingout.study.questionnaire import QuestionnaireItem

Occasion = Literal["demographics", "at_end", "after_partner", "after_round"]  # as the study file calls them
RATED: Final[tuple[Occasion, ...]] = ("after_round", "after_partner", "at_end")


class RatedItem(NamedTuple):
    """A rated question of a questionnaire."""

    questionnaire: str
    item: QuestionnaireItem
    label: str  # with the questionnaire where another one has the same label
    occasions: tuple[Occasion, ...] = RATED  # whose answers it is about


def occasion(step: str) -> Occasion:
    """When the question of a step is asked, by the form of its key (`design.steps`)."""
    by_depth: dict[int, Occasion] = {0: "demographics", 1: "at_end", 2: "after_partner"}
    return by_depth.get(step.count("/"), "after_round")


def rated_items(study: Study, language: str = DEFAULT) -> list[RatedItem]:
    """Every rated question; one that is asked after rounds and after partners is two."""
    names = [name for block in study.blocks for name in (*block.after_round, *block.after_partner)]
    found = [
        (name, item)
        for name in dict.fromkeys((*names, *study.at_end))
        for item in study.questionnaire(name, language).items
        if item.is_rated and item.expected is None
    ]
    asked_by: dict[str, set[str]] = defaultdict(set)
    for name, item in found:
        asked_by[item.label].add(name)
    labels = [item.label if len(asked_by[item.label]) == 1 else f"{item.label} ({name})" for name, item in found]
    return [
        one for (name, item), label in zip(found, labels, strict=True) for one in _by_occasion(study, name, item, label)
    ]


def _by_occasion(study: Study, name: str, item: QuestionnaireItem, label: str) -> Iterator[RatedItem]:
    asked = {"after_round": False, "after_partner": False}
    for block in study.blocks:
        asked["after_round"] |= name in block.after_round
        asked["after_partner"] |= name in block.after_partner
    if not all(asked.values()):
        yield RatedItem(name, item, label)
        return
    yield RatedItem(name, item, f"{label} (after_round)", ("after_round",))
    yield RatedItem(name, item, f"{label} (after_partner)", ("after_partner", "at_end"))
