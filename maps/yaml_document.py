"""A YAML text as plain values, with the line on which each of them stands: what studies and grids are read with."""

import json
import re
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple
from unicodedata import category

import yaml

from movingout.maps.errors import MovingOutError

FieldPath = tuple[str | int, ...]
BLANKS = ("Zs", "Cf")  # no-break and narrow spaces, soft hyphens, joiners: word processors write them
MAX_BYTES = 1 << 20
NOT_UTF8 = "is not UTF-8 text; in the editor, save it with the encoding UTF-8"
_MOST_NODES = 20_000  # aliases can blow a small file up
_LONGEST_NUMBER = 64  # letters; reading longer ones takes time that grows with the square
_BEGUN = r"simple key|quoted scalar found unexpected"  # what the parser says of something that began before
_ADVICE = (
    (r"'\\t'", "indent with spaces, not with tabs"),
    (r"simple key", "a field is NAME: VALUE, with a space after the colon"),
    (r"scalar .*escape", "in double quotes a backslash is written twice; in the path of a file, write /"),
    (r"quoted scalar", "the closing quotation mark is missing"),
    (r"single document", "remove the line ---: a file holds one document"),
    (
        r"flow mapping|flow sequence|flow node",
        "in {...} and [...], put a text with any of ? : , ' [ ] { } - in double quotes; else a bracket is not closed",
    ),
    (
        r"mapping values",
        'put a text with a colon in it in quotes, as "Note: read this"; else this line is indented wrongly',
    ),
    (r"start any token|an alias|an anchor|block scalar|block node|not allowed here", "put this text in double quotes"),
    (
        r"<block end>|<document start>",
        "this line is indented unlike its neighbours, or quotation marks around a text go wrong",
    ),
)  # by what the parser says, the first that fits
_TEXT = "tag:yaml.org,2002:str"


class FileFault(NamedTuple):
    """Something wrong in a file: the line from 1, the path of the field, and what would be right."""

    line: int
    path: str
    message: str


class YamlError(MovingOutError):
    """A text is not YAML, or holds something that no file of ours may hold."""

    def __init__(self, fault: FileFault) -> None:
        self.fault = fault
        super().__init__(f"line {fault.line}: {fault.path}: {fault.message}")


class YamlDocument:
    """The values of a YAML text: mappings with names as keys, lists and scalars. Raises YamlError."""

    def __init__(self, text: str, *, aliases: bool = True) -> None:
        self._lines: dict[FieldPath, int] = {(): 1}
        self._loader = yaml.SafeLoader(_readable(text))
        try:
            root = self._loader.get_single_node()  # gives up at deeply nested brackets, which scanning does not
            if not aliases:
                _refuse_aliases(text)
            self.value = self._value(root, (), ()) if root else None
        except yaml.MarkedYAMLError as error:
            raise _not_yaml(error) from None
        except RecursionError:
            raise _error(1, (), "lists or mappings are nested too deeply") from None
        finally:
            self._loader.dispose()

    def line(self, path: FieldPath) -> int:
        """The line of a field; of the nearest one around it where the field itself is missing."""
        while path not in self._lines:
            path = path[:-1]
        return self._lines[path]

    def path_of(self, location: Sequence[str | int], *, missing: bool) -> FieldPath:
        """The path of a pydantic location without the names that it adds for unions; `missing`: of an absent field."""
        path: FieldPath = ()
        for step in location:
            if (*path, step) in self._lines:
                path = (*path, step)
        return (*path, location[-1]) if missing else path

    def error(self, path: FieldPath, message: str) -> YamlError:
        """An error about a field, with its line."""
        return _error(self.line(path), path, message)

    def _value(self, node: yaml.Node, path: FieldPath, around: tuple[int, ...]) -> Any:
        if id(node) in around or len(self._lines) > _MOST_NODES:
            raise _error(node.start_mark.line + 1, path, "an alias (*) contains itself, or there are too many")
        self._lines.setdefault(path, node.start_mark.line + 1)
        if isinstance(node, yaml.MappingNode):
            return dict(self._entries(node, path, (*around, id(node))))
        if isinstance(node, yaml.SequenceNode):
            inner = (*around, id(node))
            return [self._value(entry, (*path, index), inner) for index, entry in enumerate(node.value)]
        line, shown = node.start_mark.line + 1, repr(node.value[:_LONGEST_NUMBER])
        if node.tag != _TEXT and len(node.value) > _LONGEST_NUMBER:
            raise _error(line, path, f"{shown} is too long for a number or a date; write a text in quotes")
        try:
            return self._loader.construct_object(node, deep=True)
        except ValueError as error:  # a date such as 2026-13-45
            raise _error(line, path, f"{shown} is not a valid value: {error}") from None

    def _entries(self, node: yaml.MappingNode, path: FieldPath, around: tuple[int, ...]) -> Iterator[tuple[str, Any]]:
        seen: set[str] = set()
        for key, value in node.value:
            line = key.start_mark.line + 1
            name = key.value if isinstance(key, yaml.ScalarNode) else ""
            if not name:
                raise _error(line, path, "the name of a field must be text")
            if name in seen:
                raise _error(line, (*path, name), f"{name!r} appears twice; remove one")
            seen.add(name)
            self._lines[(*path, name)] = line
            yield name, self._value(value, (*path, name), around)


def utf8_text(content: bytes) -> str:
    """The text of a file's bytes. Raises YamlError with the line of the first byte that is no UTF-8."""
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError as error:
        raise _error(content.count(b"\n", 0, error.start) + 1, (), NOT_UTF8) from None


def path_text(path: FieldPath) -> str:
    """A path as people write it: blocks[0].maps."""
    text = ""
    for part in path:
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else part
    return text or "the file"


def list_needed(value: object) -> str:
    """What to say of a value where a list is needed: how the list of this one entry, or of these, is written."""
    if not isinstance(value, str):
        return "a list is needed here"
    if re.fullmatch(r"[A-Za-z0-9_./-]+(, *[A-Za-z0-9_./-]+)+", value):
        return f"a list is needed here; write [{value}]"
    plain = re.fullmatch(r"[A-Za-z0-9_./-]+", value)
    return f"a list is needed here; for one entry, write [{value if plain else json.dumps(value, ensure_ascii=False)}]"


def _error(line: int, path: FieldPath, message: str) -> YamlError:
    return YamlError(FileFault(line, path_text(path), message))


def _not_yaml(error: yaml.MarkedYAMLError) -> YamlError:
    """What the parser says, and what would be right where people often write something else."""
    problem = " ".join(part for part in (error.context, error.problem) if part)
    advice = next((f"; {words}" for pattern, words in _ADVICE if re.search(pattern, problem)), "")
    begun = re.search(_BEGUN, problem)  # noticed later, perhaps lines later
    mark = (error.context_mark if begun else None) or error.problem_mark or error.context_mark
    return _error((mark.line if mark else 0) + 1, (), f"this is not YAML: {problem}{advice}")


def _refuse_aliases(text: str) -> None:
    for token in yaml.scan(text):
        if isinstance(token, yaml.AliasToken):
            raise _error(token.start_mark.line + 1, (), f"no aliases (*{token.value}); write it out")


def _readable(text: str) -> str:
    if len(text.encode()) > MAX_BYTES:
        raise _error(1, (), "the file is larger than 1 MiB; a page or two is enough")
    for number, line in enumerate(text.splitlines(), 1):
        if not all(letter.isprintable() or letter == "\t" or category(letter) in BLANKS for letter in line):
            raise _error(number, (), "holds a control character; save it as UTF-8 text")
    return text
