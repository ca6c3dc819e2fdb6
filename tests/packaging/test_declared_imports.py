"""What our modules import is required by our own name, not only by that of a package that happens to need it, too."""

import ast
import sys
import tomllib
from collections.abc import Iterator
from importlib.metadata import packages_distributions

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tests.support import ROOT

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
EXTRAS = PROJECT["optional-dependencies"]
OURS = {"movingout", "tests", "bench"}
BROUGHT = {"lerobot", "sb3-contrib", "stable-baselines3"}  # by whoever has a policy of theirs; an error names them
ELSEWHERE = {"overcooked_ai_py": "overcooked-ai"}  # not in the environment of the tests
NOWHERE = {"no-such-library"}  # of a test


def _declared(*extras: str) -> set[str]:
    lines = [*PROJECT["dependencies"], *(line for extra in extras for line in EXTRAS[extra])]
    return {canonicalize_name(Requirement(line).name) for line in lines}


def _imported(folder: str) -> Iterator[str]:
    """The top-level names that modules of a folder import, as they are written."""
    for path in (ROOT / folder).rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_bytes())):
            if isinstance(node, ast.Import):
                yield from (alias.name.partition(".")[0] for alias in node.names)
            elif isinstance(node, ast.ImportFrom) and node.module and node.level == 0:
                yield node.module.partition(".")[0]


def _undeclared(folders: tuple[str, ...], declared: set[str]) -> dict[str, set[str]]:
    """The distributions of each import that is not declared; a namespace package belongs to several."""
    known = packages_distributions()
    names = {name for folder in folders for name in _imported(folder)} - OURS - sys.stdlib_module_names
    found = {
        name: {str(canonicalize_name(one)) for one in known.get(name, [ELSEWHERE.get(name, name)])} for name in names
    }
    return {name: owners for name, owners in found.items() if not owners & declared}


@pytest.mark.slow
def test_each_import_is_declared() -> None:
    """zstandard came with mcap alone: the day it does not, no recording opens."""
    optional = [extra for extra in EXTRAS if extra != "dev"]
    packages = ("agents", "maps", "matches", "recordings", "server", "study", "world")
    assert _undeclared(packages, _declared(*optional) | BROUGHT) == {}
    assert _undeclared(("bench", "tests"), _declared(*EXTRAS) | BROUGHT | NOWHERE) == {}


def test_what_opens_recordings_and_serves_pages_needs_no_extra() -> None:
    assert {"mcap", "zstandard", "fastapi", "starlette"} <= _declared()
