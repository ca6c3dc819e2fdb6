"""The study files that come with the project, commented, to start from."""

from pathlib import Path

from movingout.study.errors import StudyError

_FOLDER = Path(__file__).parents[1] / "templates"


def template_names() -> tuple[str, ...]:
    return tuple(sorted(path.stem for path in _FOLDER.glob("*.yaml")))


def template_text(name: str) -> str:
    """The text of a template; StudyError names the known ones."""
    if name not in template_names():
        raise StudyError(f"unknown template {name!r}; known: {', '.join(template_names())}")
    return (_FOLDER / f"{name}.yaml").read_text(encoding="utf-8")
