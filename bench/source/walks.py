"""The walks of docs/architecture.md: the files that a key press and an agent's decision pass through, in order.

A walk is a numbered list below a heading that contains its title; each item begins with a path in backticks:

    ## A key press
    1. `web/input/keyboard.js`: …
    6. `server/connection/endpoint.py` (wire): …

Each file must exist and be linked by an import, in either direction, with one that stands before it in the walk. If it
is reached over a socket or a pipe instead, "(wire)" follows the path; if its caller knows only a protocol that it
implements, "(protocol)".
"""

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

PAGE = Path("docs/architecture.md")
TARGETS = {"key press": "14", "decision": "9"}
"""The most files each walk should have, by title."""

_ITEM = re.compile(r"\s*\d+\.\s+`([^`]+)`\s*(\((?:wire|protocol)\))?")
_JS_IMPORT = re.compile(r"""(?:from|import)\s*\(?\s*["'](\.[^"']+)["']""")


@dataclass(frozen=True)
class Walk:
    """One walk and what is wrong with it."""

    title: str
    target: str
    files: list[str]
    faults: list[str]


def walks(root: Path) -> list[Walk]:
    """The two walks; one missing from the page has no files and a fault."""
    page = root / PAGE
    text = page.read_text(encoding="utf-8") if page.exists() else ""
    return [_walk(root, text, title) for title in TARGETS]


def _walk(root: Path, text: str, title: str) -> Walk:
    items = list(_items(text, title))
    faults = [] if items else [f"{PAGE} has no numbered list below a heading with {title!r}"]
    before: list[str] = []
    for path, not_imported in items:
        if not (root / path).is_file():
            faults.append(f"{title}: {path} does not exist")
        elif before and not not_imported and not any(_linked(root, path, other) for other in before):
            faults.append(f"{title}: no import links {path} with a file before it")
        before.append(path)
    return Walk(title, TARGETS[title], before, faults)


def _items(text: str, title: str) -> Iterator[tuple[str, bool]]:
    """(path, whether no import leads to it) of each numbered item below the heading."""
    inside = False
    for line in text.splitlines():
        if line.startswith("#"):
            inside = title in line.lower()
        elif inside and (match := _ITEM.match(line)):
            yield match[1], match[2] is not None


def _linked(root: Path, one: str, other: str) -> bool:
    return other in _imports(root, one) or one in _imports(root, other)


def _imports(root: Path, path: str) -> set[str]:
    """The files that a file imports, relative to the root."""
    file = root / path
    if not file.is_file():
        return set()
    text = file.read_text(encoding="utf-8")
    if file.suffix == ".js":
        return {str((file.parent / name).resolve().relative_to(root)) for name in _JS_IMPORT.findall(text)}
    return set(_python_imports(root, ast.parse(text)))


def _python_imports(root: Path, tree: ast.AST) -> Iterator[str]:
    """Imported files; a name imported from a package counts as imported from the module that defines it."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("movingout."):
            folder = Path(*node.module.split(".")[1:])
            yield f"{folder}.py"
            for alias in node.names:
                yield str(folder / f"{alias.name}.py")
            if (package := root / folder / "__init__.py").is_file():
                yield from _python_imports(root, ast.parse(package.read_text(encoding="utf-8")))
