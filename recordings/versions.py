"""Versions of the software that made a recording: equal floats need the same engine, equal episodes the same code."""

import ast
import platform
from collections.abc import Mapping
from functools import cache
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

_THAT_PLAY = ("agents", "maps", "matches", "world")
_NOT_IN_PLAY = {"commands", "curriculum", "paper", "report", "training"}  # folders of these packages
_DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


@cache
def versions() -> dict[str, str]:
    """This installation, as written into each recording."""
    return {
        "movingout": _version("moving-out-live"),
        "pymunk": _version("pymunk"),
        "numpy": _version("numpy"),
        "python": platform.python_version(),
        "machine": platform.machine(),
        "system": platform.system(),
    }


@cache
def code_sha256() -> str:
    """A hash of the project's code that takes part in play: with other code, a match may have another outcome.

    Comments, docstrings and the layout of a source do not count. The first call takes about a second.
    """
    root = Path(__file__).parents[1]
    paths = [path for package in _THAT_PLAY for path in sorted((root / package).rglob("*.py"))]
    digest = sha256()
    for path in paths:
        if not _NOT_IN_PLAY & set(path.relative_to(root).parts):
            digest.update(meaning(path.read_bytes()).encode())
    return digest.hexdigest()


def meaning(source: bytes) -> str:
    """The syntax tree of a source without comments and docstrings."""
    return _written(ast.parse(source))


def _written(node: object) -> str:
    """As `ast.dump`, but without what is empty: other versions of Python have other fields that we do not use."""
    if isinstance(node, list):
        return f"[{','.join([_written(one) for one in node])}]"
    if not isinstance(node, ast.AST):
        return repr(node)
    if isinstance(node, _DOCUMENTED) and ast.get_docstring(node, clean=False) is not None:
        node.body = node.body[1:]
    values = [(name, getattr(node, name, None)) for name in node._fields]
    return (
        f"{type(node).__name__}({','.join([f'{name}={_written(at)}' for name, at in values if at not in (None, [])])})"
    )


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "unknown"


def why_not_exact(recorded: Mapping[str, str]) -> str:
    """Why equal floats are not guaranteed for a recording made elsewhere; empty when they are."""
    here = versions()
    differing = [
        f"{name} {recorded.get(name, 'unknown')} (here {here[name]})"
        for name in ("pymunk", "machine", "system")
        if recorded.get(name, here[name] if name != "pymunk" else "") != here[name]
    ]
    return f"recorded with {', '.join(differing)}: equal bits are not promised" if differing else ""
