"""Whether a study has every text in every language that it promises."""

import json
from collections.abc import Iterator
from functools import cache

from movingout.recordings.report.words import PAGES
from movingout.study.design.definition import Study
from movingout.study.design.instruments import instrument_names, instrument_speaks
from movingout.study.design.localized_text import LocalizedText
from movingout.study.design.sections.questionnaire_spec import QuestionnaireSpec, QuestionSpec


def missing_texts(study: Study) -> tuple[str, ...]:
    """A sentence per text and language that is missing, in the order of the study file."""
    return tuple(
        f"{name} has no text in {language!r}, which `languages` promises"
        for language in study.languages
        for name, found in _texts(study, language)
        if not found
    )


def questionnaires_asked(study: Study) -> tuple[str, ...]:
    """The questionnaires that participants meet, each once."""
    names = [study.demographics] if study.demographics else []
    names += [name for block in study.blocks for name in (*block.after_round, *block.after_partner)]
    return tuple(dict.fromkeys((*names, *study.at_end)))


def _texts(study: Study, language: str) -> Iterator[tuple[str, bool]]:
    """What participants read, and whether it is there."""

    def has(text: LocalizedText) -> bool:
        return language in text.root

    yield "every page", page_words(language) is not None
    yield "title", has(study.title)
    yield "consent.text", has(study.consent.text)
    for box in study.consent.boxes:
        yield f"consent box {box.id!r}", has(box.text)
    own = {one.id: one for one in study.questionnaires}
    for name in questionnaires_asked(study):
        base = own[name].base if name in own else name
        if base in instrument_names():
            yield f"the ready-made questionnaire {base!r}", instrument_speaks(base, language)
        if name in own:
            yield from _questionnaire_texts(own[name], language)
    for name in _maps_played(study):
        text = study.map_texts.get(name)
        if text is not None:
            yield f"the title of map {name!r}", has(text.title)
            yield f"the description of map {name!r}", has(text.description)
        elif len(study.languages) > 1:  # in a study of one language, the map file has that language
            yield f"map {name!r} (give its title and description in `map_texts`)", _pages_name(study, name, language)
    if study.debrief is not None:
        yield "debrief.text", has(study.debrief.text)


def _maps_played(study: Study) -> tuple[str, ...]:
    practice = [study.practice.map] if study.practice else []
    return tuple(dict.fromkeys([*practice, *(name for block in study.blocks for name in block.maps)]))


def _pages_name(study: Study, name: str, language: str) -> bool:
    """Whether the pages have a title and a description of the map."""
    words = page_words(language) or {}
    known = study.load_map(name).name.partition(":")[0]  # the pages have words for mirrored and turned
    return f"map.{known}.title" in words and f"map.{known}.description" in words


@cache
def page_words(language: str) -> dict[str, str] | None:
    """What the pages say in a language, by key; None where they do not speak it."""
    file = PAGES / f"{language.partition('-')[0]}.json"
    if not file.is_file():
        return None
    words: dict[str, str] = json.loads(file.read_text(encoding="utf-8"))
    return words


def _questionnaire_texts(form: QuestionnaireSpec, language: str) -> Iterator[tuple[str, bool]]:
    if form.title is not None:
        yield f"the title of questionnaire {form.id!r}", language in form.title.root
    for item in form.items:
        yield f"item {item.id!r} of questionnaire {form.id!r}", _item_has(item, language)


def _item_has(item: QuestionSpec, language: str) -> bool:
    return all(language in text.root for text in (item.text, *item.options, *(item.ends or ())))
