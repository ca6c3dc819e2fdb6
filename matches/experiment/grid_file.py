"""A YAML file checked against a pydantic model; each fault is named with its line and its path."""

from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from movingout.maps.files.input_file import read_input
from movingout.maps.suggestion import known_names
from movingout.maps.yaml_document import FieldPath, YamlDocument, YamlError, list_needed, path_text, utf8_text
from movingout.matches.errors import MatchError

MOST_FAULTS = 5  # in one message

Model = TypeVar("Model", bound=BaseModel)


def read_grid_file(path: Path, model: type[Model]) -> Model:
    """The file as a model. Raises MatchError: unreadable, not YAML, or not what the model asks for."""
    try:
        document = YamlDocument(utf8_text(read_input(path)), aliases=False)
    except OSError as error:
        raise MatchError(f"cannot read {path}: {error.strerror or error}") from error
    except YamlError as error:
        raise MatchError(f"{path}: {error}") from error
    if not isinstance(document.value, dict):
        raise MatchError(f"{path}: the file should have lines like 'name: ...', see docs/matches.md")
    try:
        return model.model_validate(document.value)
    except ValidationError as error:
        raise MatchError(f"{path}: {'; '.join(_faults(error, document, model))}") from error


def _faults(error: ValidationError, document: YamlDocument, model: type[BaseModel]) -> list[str]:
    """One phrase per fault; of a union only the alternative that matched the most of the path."""
    deepest: dict[int, tuple[int, str]] = {}
    for fault in error.errors():
        path = document.path_of(fault["loc"], missing=fault["type"] == "missing")
        line, message = document.line(path), _message(fault, path, model)
        if line not in deepest or len(path) > deepest[line][0]:
            deepest[line] = len(path), f"line {line}: {path_text(path)}: {message}"
    return [text for _, (_, text) in sorted(deepest.items())][:MOST_FAULTS]


def _message(fault: Any, path: FieldPath, model: type[BaseModel]) -> str:
    kind = fault["type"]
    if kind == "missing":
        return "this field is missing"
    if kind == "extra_forbidden":
        known = f"; {known_names(str(path[0]), model.model_fields)}" if len(path) == 1 else ""
        return f"there is no such field{known}"
    if kind == "list_type":
        return list_needed(fault["input"])
    message = str(fault["msg"]).removeprefix("Value error, ")
    return message[:1].lower() + message[1:]
