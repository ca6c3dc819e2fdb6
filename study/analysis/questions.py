"""The questions of a study whose answers the report sums up, and when each is asked."""

from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping
from typing import Final, Literal, NamedTuple

from movingout.study.design.definition import Study
from movingout.study.design.localized_text import DEFAULT
from movingout.study.questionnaire import QuestionnaireItem

Occasion = Literal["demographics", "at_end", "after_partner", "after_round"]  # as the study file calls them
RATED: Final[tuple[Occasion, ...]] = ("after_round", "after_partner", "at_end")
ABOUT_NOBODY: Final[tuple[Occasion, ...]] = ("demographics", "at_end")


class AskedItem(NamedTuple):
    """A question of a questionnaire."""

    questionnaire: str
    item: QuestionnaireItem
    label: str  # with what tells it apart, where another one has the same label
    occasions: tuple[Occasion, ...] = RATED  # whose answers it is about


Found = tuple[str, QuestionnaireItem]  # the questionnaire, and the item in it


def occasion(step: str) -> Occasion:
    """When the question of a step is asked, by the form of its key (`design.steps`)."""
    by_depth: dict[int, Occasion] = {0: "demographics", 1: "at_end", 2: "after_partner"}
    return by_depth.get(step.count("/"), "after_round")


def rated_items(study: Study, language: str = DEFAULT) -> list[AskedItem]:
    """Every rated question but those of demographics; one that is asked after rounds and after partners is several."""
    found = [(name, item) for name, item in _about_partners(study, language) if item.is_rated]
    return list(_by_occasion(study, found, _labels(found)))


def counted_items(study: Study, language: str = DEFAULT) -> list[AskedItem]:
    """Every question whose answers are counted: choices and other values, and what is rated in demographics."""
    names = [study.demographics] if study.demographics else []
    first = [(name, item) for name, item in _items(study, names, language) if not item.is_text]
    later = [(name, item) for name, item in _about_partners(study, language) if not (item.is_rated or item.is_text)]
    labels = _labels([*first, *later])
    demographics = [AskedItem(name, item, labels[name, item.id], ("demographics",)) for name, item in first]
    return [*demographics, *_by_occasion(study, later, labels)]


def _about_partners(study: Study, language: str) -> list[Found]:
    names = [name for block in study.blocks for name in (*block.after_round, *block.after_partner)]
    return _items(study, dict.fromkeys((*names, *study.at_end)), language)


def _items(study: Study, names: Iterable[str], language: str) -> list[Found]:
    """All but attention items, which are flagged."""
    return [
        (name, item) for name in names for item in study.questionnaire(name, language).items if item.expected is None
    ]


def _labels(found: Iterable[Found]) -> dict[tuple[str, str], str]:
    """By questionnaire and item: the label, with the questionnaire or the item's id where others have the same."""
    same: dict[str, set[tuple[str, str]]] = defaultdict(set)
    for name, item in found:
        same[item.label].add((name, item.id))
    labels = {}
    for label, asked in same.items():
        in_all = Counter(name for name, _ in asked)
        for name, id in asked:
            marks = [*([name] if len(in_all) > 1 else []), *([id] if in_all[name] > 1 else [])]
            labels[name, id] = f"{label} ({', '.join(marks)})" if marks else label
    return labels


def _by_occasion(study: Study, found: Iterable[Found], labels: Mapping[tuple[str, str], str]) -> Iterator[AskedItem]:
    after_round = {name for block in study.blocks for name in block.after_round}
    after_partner = {name for block in study.blocks for name in block.after_partner}
    for name, item in found:
        label = labels[name, item.id]
        if name in after_round & after_partner:
            yield AskedItem(name, item, f"{label} (after_round)", ("after_round",))
            yield AskedItem(name, item, f"{label} (after_partner)", ("after_partner",))
            if name in study.at_end:
                yield AskedItem(name, item, f"{label} (at_end)", ("at_end",))
        else:
            yield AskedItem(name, item, label)
