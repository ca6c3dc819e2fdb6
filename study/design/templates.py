"""The study files that come with the project, commented, to start from; their texts are in every language of ours."""

import re
from collections.abc import Sequence
from pathlib import Path

from movingout.maps.suggestion import known_names
from movingout.study.errors import StudyError

LANGUAGES = ("en", "de")  # of the templates' texts, in the order in which a file lists them
_FOLDER = Path(__file__).parents[1] / "templates"


def template_names() -> tuple[str, ...]:
    return tuple(sorted(path.stem for path in _FOLDER.glob("*.yaml")))


def template_text(name: str, languages: Sequence[str] = ("en",)) -> str:
    """The text of a template with the texts of some languages; StudyError names the known templates and languages."""
    if name not in template_names():
        raise StudyError(f"unknown template {name!r}; {known_names(name, template_names())}")
    unknown = [language for language in languages if language not in LANGUAGES]
    if unknown:
        raise StudyError(f"templates have no texts in {_listed(unknown)}; they have {_listed(LANGUAGES)}")
    text = (_FOLDER / f"{name}.yaml").read_text(encoding="utf-8")
    for language in LANGUAGES:
        if language not in languages:
            text = _without(text, language)
    kept = [language for language in LANGUAGES if language in languages]
    return text.replace(f"languages: [{_listed(LANGUAGES)}]", f"languages: [{_listed(kept)}]", 1)


def _without(text: str, language: str) -> str:
    """The file without the texts of a language: the lines that name it, and the deeper ones below each."""
    return re.sub(rf"^( +){language}:.*\n(?:\1 +.*\n|\n(?=\1 ))*", "", text, flags=re.MULTILINE)


def _listed(languages: Sequence[str]) -> str:
    return ", ".join(languages)
