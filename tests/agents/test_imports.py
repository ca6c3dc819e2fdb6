"""No module of `agents` needs itself: imports inside functions count too, those for type checkers do not."""

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from movingout.agents import base

ROOT = Path(base.__file__).resolve().parent
PACKAGE = "movingout.agents"


def test_there_is_no_circle_of_imports() -> None:
    graph = {_name(file): set(_imported(file)) & _modules() for file in ROOT.rglob("*.py")}
    while leaves := [name for name, needs in graph.items() if not needs & graph.keys()]:
        for name in leaves:
            del graph[name]
    assert not graph, f"these import each other: {sorted(graph)}"


@cache
def _modules() -> frozenset[str]:
    return frozenset(_name(file) for file in ROOT.rglob("*.py"))


def _name(file: Path) -> str:
    parts = file.relative_to(ROOT).with_suffix("").parts
    return ".".join((PACKAGE, *(parts[:-1] if parts[-1] == "__init__" else parts)))


def _imported(file: Path) -> Iterator[str]:
    """Modules imported anywhere in a file, but for `if TYPE_CHECKING`; packages that lead to them do not count."""
    for node in _without_type_checking(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module and node.level == 0:
            submodules = {f"{node.module}.{alias.name}" for alias in node.names} & _modules()
            yield from submodules or {node.module}
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)


def _without_type_checking(tree: ast.AST) -> Iterator[ast.AST]:
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            continue
        yield node
        yield from _without_type_checking(node)
