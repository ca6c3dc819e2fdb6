"""The source files of the project and figures about them."""

import ast
from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PYTHON_PACKAGES = ("maps", "world", "recordings", "agents", "matches", "study", "server")
FOLDERS = (*PYTHON_PACKAGES, "src/movingout", "web")  # what `src/movingout` links to counts once
GENERATED = (Path("web/messages.js"),)
LONGEST_JS_LINE = 120
_BROAD = ("Exception", "BaseException")

Function = ast.FunctionDef | ast.AsyncFunctionDef


@dataclass(frozen=True)
class SourceTree:
    """The Python and JavaScript files that people write, below a root folder. Paths are relative to the root."""

    root: Path = ROOT

    @cached_property
    def python(self) -> dict[Path, ast.Module]:
        """Syntax trees by path."""
        return {path: ast.parse((self.root / path).read_text(encoding="utf-8")) for path in self._paths(".py")}

    @cached_property
    def line_counts(self) -> dict[Path, int]:
        """Lines of every file."""
        paths = (*self._paths(".py"), *self._paths(".js"))
        return {path: len((self.root / path).read_text(encoding="utf-8").splitlines()) for path in paths}

    @property
    def folder_sizes(self) -> Counter[Path]:
        """Files directly in each folder, without `__init__.py`."""
        return Counter(path.parent for path in self.line_counts if path.name != "__init__.py")

    @property
    def functions(self) -> list[Function]:
        return [node for node in self._nodes() if isinstance(node, Function)]

    @property
    def function_lengths(self) -> list[int]:
        """Lines of each function from `def` to its end, sorted."""
        return sorted((node.end_lineno or node.lineno) - node.lineno + 1 for node in self.functions)

    @property
    def annotated_share(self) -> float:
        """Share of functions whose arguments (except self and cls) and result all have types."""
        functions = self.functions
        return sum(map(_is_annotated, functions)) / len(functions) if functions else 1.0

    @property
    def handlers(self) -> tuple[int, int]:
        """Number of `except` clauses that catch everything, and of all."""
        found = [node for node in self._nodes() if isinstance(node, ast.ExceptHandler)]
        return sum(map(_is_broad, found)), len(found)

    @property
    def long_js_lines(self) -> list[str]:
        """`path:line` of every JavaScript line over 120 characters."""
        return [
            f"{path}:{number}"
            for path in self._paths(".js")
            for number, line in enumerate((self.root / path).read_text(encoding="utf-8").splitlines(), start=1)
            if len(line) > LONGEST_JS_LINE
        ]

    @property
    def recurring_classes(self) -> dict[str, list[Path]]:
        """Names of classes that are defined in more than one module, with the modules."""
        homes: dict[str, list[Path]] = defaultdict(list)
        for path, tree in self.python.items():
            for name in sorted({node.name for node in ast.walk(tree) if isinstance(node, ast.ClassDef)}):
                homes[name].append(path)
        return {name: paths for name, paths in sorted(homes.items()) if len(paths) > 1}

    def _paths(self, suffix: str) -> list[Path]:
        found = {path.relative_to(self.root) for folder in FOLDERS for path in (self.root / folder).rglob(f"*{suffix}")}
        return sorted(found.difference(GENERATED))

    def _nodes(self) -> Iterator[ast.AST]:
        for tree in self.python.values():
            yield from ast.walk(tree)


def _is_annotated(function: Function) -> bool:
    arguments = function.args
    named = [*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs]
    starred = [argument for argument in (arguments.vararg, arguments.kwarg) if argument is not None]
    typed = all(argument.annotation or argument.arg in ("self", "cls") for argument in (*named, *starred))
    return typed and function.returns is not None


def _is_broad(handler: ast.ExceptHandler) -> bool:
    caught = handler.type.elts if isinstance(handler.type, ast.Tuple) else [handler.type]
    return any(one is None or (isinstance(one, ast.Name) and one.id in _BROAD) for one in caught)
