"""Ready-made questionnaires besides the paper's: NASA-TLX and a short demographic form.

They are written in English; `instruments_de` and its like hold their translations.

NASA-TLX: the six scales of the paper-and-pencil form of Hart and Staveland's Task Load Index (NASA Ames Research
Center), unweighted ("raw TLX"); 21 gradations, 0 to 20. Performance runs from perfect to failure, as on the form.
The demographic form asks for ranges, never for exact values; every question can be left unanswered.
"""

from collections.abc import Mapping
from typing import Final

from movingout.study.design import instruments_de
from movingout.study.design.instrument_text import InstrumentText
from movingout.study.design.localized_text import DEFAULT
from movingout.study.errors import StudyError
from movingout.study.questionnaire import PAPER, PAPER_EIGHT, Questionnaire, QuestionnaireItem


def _tlx(id: str, label: str, text: str, ends: tuple[str, str] = ("Very low", "Very high")) -> QuestionnaireItem:
    return QuestionnaireItem(id, "tlx", label, text, ends=ends)


def _choice(id: str, text: str, *options: str) -> QuestionnaireItem:
    return QuestionnaireItem(id, "choice", id.replace("_", " ").capitalize(), text, options=options)


NASA_TLX: Final = Questionnaire(
    id="nasa-tlx",
    title="How demanding it was",
    items=(
        _tlx("mental", "Mental demand", "How mentally demanding was the task?"),
        _tlx("physical", "Physical demand", "How physically demanding was the task?"),
        _tlx("temporal", "Temporal demand", "How hurried or rushed was the pace of the task?"),
        _tlx(
            "performance",
            "Performance",
            "How successful were you in accomplishing what you were asked to do?",
            ("Perfect", "Failure"),
        ),
        _tlx("effort", "Effort", "How hard did you have to work to accomplish your level of performance?"),
        _tlx("frustration", "Frustration", "How insecure, discouraged, irritated, stressed, and annoyed were you?"),
    ),
)
DEMOGRAPHICS: Final = Questionnaire(
    id="demographics",
    title="About you",
    items=(
        _choice("age", "How old are you?", "18–24", "25–34", "35–44", "45–54", "55–64", "65 or older"),
        _choice("gender", "What is your gender?", "Woman", "Man", "Non-binary", "Another"),
        _choice("hand", "Which hand do you write with?", "Left", "Right", "Both equally"),
        _choice("colour_vision", "Do you have trouble telling colours apart?", "No", "Yes"),
        _choice("gaming", "How many hours a week do you play video games?", "None", "Up to 2", "3 to 7", "8 or more"),
        _choice("gamepad", "How often have you used a gamepad?", "Never", "A few times", "Often"),
        _choice("played_before", "Have you played Moving Out before?", "No", "Yes"),
    ),
)
_READY = {one.id: one for one in (PAPER, PAPER_EIGHT, NASA_TLX, DEMOGRAPHICS)}
TRANSLATIONS: Final[Mapping[str, Mapping[str, InstrumentText]]] = {"de": instruments_de.TEXTS}
"""By language, then by questionnaire."""


def instrument_names() -> tuple[str, ...]:
    return tuple(_READY)


def instrument(name: str, language: str = DEFAULT) -> Questionnaire:
    """A ready-made questionnaire in a language, in English where it is not translated; StudyError names the known."""
    if name not in _READY:
        raise StudyError(f"unknown questionnaire {name!r}; ready-made: {', '.join(_READY)}")
    translation = _translation(name, language)
    return _READY[name] if translation is None else translation.translate(_READY[name])


def instrument_speaks(name: str, language: str) -> bool:
    """Whether there is a text of the ready-made questionnaire in the language."""
    return _base(language) == DEFAULT or _translation(name, language) is not None


def _translation(name: str, language: str) -> InstrumentText | None:
    return TRANSLATIONS.get(_base(language), {}).get(name)


def _base(language: str) -> str:
    """The language without its region: pt of pt-BR."""
    return language.partition("-")[0]
