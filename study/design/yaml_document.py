"""A YAML text as plain values, with the line on which each of them stands."""

from collections.abc import Iterator
from typing import Any

import yaml

from movingout.study.errors import Fault, StudyFileError

Path = tuple[str | int, ...]
MAX_BYTES = 1 << 20
_MOST_NODES = 20_000  # aliases can blow a small file up


class Document:
    """The values of a YAML text: mappings, lists and scalars. Raises StudyFileError for broken YAML."""

    def __init__(self, text: str, name: str) -> None:
        self._name = name
        self._lines: dict[Path, int] = {(): 1}
        self._loader = yaml.SafeLoader(_readable(text, name))
        try:
            root = self._loader.get_single_node()
            self.value = self._value(root, (), ()) if root else None
        except yaml.MarkedYAMLError as error:
            mark = error.problem_mark or error.context_mark
            problem = " ".join(part for part in (error.context, error.problem) if part)
            raise self.error((mark.line if mark else 0) + 1, (), f"this is not YAML: {problem}") from None
        finally:
            self._loader.dispose()

    def line(self, path: Path) -> int:
        """The line of a field; of the nearest one around it where the field itself is missing."""
        while path not in self._lines:
            path = path[:-1]
        return self._lines[path]

    def error(self, line: int, path: Path, message: str) -> StudyFileError:
        return StudyFileError(self._name, [Fault(line, words(path), message)])

    def _value(self, node: yaml.Node, path: Path, around: tuple[int, ...]) -> Any:
        if id(node) in around or len(self._lines) > _MOST_NODES:
            raise self.error(node.start_mark.line + 1, path, "an alias (*) contains itself, or there are too many")
        self._lines.setdefault(path, node.start_mark.line + 1)
        if isinstance(node, yaml.MappingNode):
            return dict(self._entries(node, path, (*around, id(node))))
        if isinstance(node, yaml.SequenceNode):
            inner = (*around, id(node))
            return [self._value(entry, (*path, index), inner) for index, entry in enumerate(node.value)]
        try:
            return self._loader.construct_object(node, deep=True)
        except ValueError as error:  # a date such as 2026-13-45
            raise self.error(node.start_mark.line + 1, path, f"{node.value!r} is no value: {error}") from None

    def _entries(self, node: yaml.MappingNode, path: Path, around: tuple[int, ...]) -> Iterator[tuple[str, Any]]:
        seen: set[str] = set()
        for key, value in node.value:
            line = key.start_mark.line + 1
            name = key.value if isinstance(key, yaml.ScalarNode) else ""
            if not name:
                raise self.error(line, path, "the name of a field is a word")
            if name in seen:
                raise self.error(line, (*path, name), f"{name!r} stands here twice; remove one")
            seen.add(name)
            self._lines[(*path, name)] = line
            yield name, self._value(value, (*path, name), around)


def words(path: Path) -> str:
    """A path as people write it: blocks[0].maps."""
    text = ""
    for part in path:
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else part
    return text or "the file"


def _readable(text: str, name: str) -> str:
    if len(text.encode()) > MAX_BYTES:
        raise StudyFileError(name, [Fault(1, "the file", "a study file has at most 1 MiB")])
    for number, line in enumerate(text.splitlines(), 1):
        if not all(letter.isprintable() or letter in "\t\ufeff" for letter in line):
            raise StudyFileError(name, [Fault(number, "the file", "holds a control character; save it as UTF-8 text")])
    return text
