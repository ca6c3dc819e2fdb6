"""A YAML file checked against a pydantic model; a fault is named with its line and its path."""

from collections.abc import Sequence
from pathlib import Path
from typing import TypeVar

import yaml
from pydantic import BaseModel, ValidationError

from movingout.matches.errors import MatchError

MAX_BYTES = 1 << 20

Model = TypeVar("Model", bound=BaseModel)


def read_yaml(path: Path, model: type[Model]) -> Model:
    """The file as a model. Raises MatchError: unreadable, no YAML, or not what the model asks for."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise MatchError(f"cannot read {path}: {error.strerror or error}") from error
    if len(data) > MAX_BYTES:
        raise MatchError(f"{path} has more than {MAX_BYTES} bytes; a grid is a page or two")
    try:
        text = data.decode("utf-8")
        root = _composed(path, text)
        document = yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise MatchError(f"{path} is no YAML: {' '.join(str(error).split())}") from error
    except (UnicodeDecodeError, RecursionError) as error:
        raise MatchError(f"{path} is no YAML text: {error}") from error
    if not isinstance(document, dict):
        raise MatchError(f"{path}: the file should have lines like 'name: ...', see docs/matches.md")
    try:
        return model.model_validate(document)
    except ValidationError as error:
        raise MatchError(f"{path}: {'; '.join(_faults(error, root))}") from error


def _composed(path: Path, text: str) -> yaml.Node | None:
    """The tree with line numbers. Aliases and double keys, which YAML would take silently, are refused."""
    for token in yaml.scan(text):
        if isinstance(token, yaml.AliasToken):
            raise MatchError(f"{path}, line {token.start_mark.line + 1}: no aliases (*{token.value}); write it out")
    root = yaml.compose(text)
    if root is not None:
        _refuse_double_keys(path, root)
    return root


def _refuse_double_keys(path: Path, node: yaml.Node) -> None:
    seen: set[str] = set()
    for child in node.value if isinstance(node, yaml.SequenceNode) else ():
        _refuse_double_keys(path, child)
    for key, value in node.value if isinstance(node, yaml.MappingNode) else ():
        if key.value in seen:
            raise MatchError(f"{path}, line {key.start_mark.line + 1}: {key.value!r} stands there twice")
        seen.add(key.value)
        _refuse_double_keys(path, value)


def _faults(error: ValidationError, root: yaml.Node | None) -> list[str]:
    """One phrase per fault, at most five; of a union only the alternative that came farthest."""
    deepest: dict[int, tuple[int, str]] = {}
    for fault in error.errors():
        line, steps = _line_of(root, fault["loc"])
        where = ".".join(str(step) for step in steps) or "the file"
        message = fault["msg"].removeprefix("Value error, ")
        text = f"line {line}: {where}: {message}"
        if line not in deepest or len(steps) > deepest[line][0]:
            deepest[line] = len(steps), text
    return [text for _, (_, text) in sorted(deepest.items())][:5]


def _line_of(root: yaml.Node | None, location: Sequence[int | str]) -> tuple[int, list[int | str]]:
    """The line (from 1) of a place, and its path without the names that pydantic adds for unions."""
    node, line, steps = root, 1, []
    for step in location:
        child: yaml.Node | None = None
        if isinstance(node, yaml.MappingNode):
            for key, value in node.value:
                if key.value == step:
                    child, line = value, key.start_mark.line + 1
        elif isinstance(node, yaml.SequenceNode) and isinstance(step, int) and step < len(node.value):
            child = node.value[step]
            line = child.start_mark.line + 1
        if child is not None:
            node = child
            steps.append(step)
        elif isinstance(node, yaml.MappingNode) and isinstance(step, str) and step == location[-1]:
            steps.append(step)  # a key that is missing
    return line, steps
