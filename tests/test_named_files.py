"""Every file, module and benchmark that the documentation, the Makefile or a source file names exists."""

import importlib
import importlib.util
import re
from pathlib import Path

import pytest

from bench.source.files import ROOT, SourceTree

PAGES = ["README.md", "CONTRIBUTING.md", "Makefile", *(f"docs/{page.name}" for page in (ROOT / "docs").glob("*.md"))]
SOURCES = [*SourceTree().line_counts, *(path.relative_to(ROOT) for path in (ROOT / "bench").rglob("*.py"))]
FOLDERS = "maps|world|recordings|agents|matches|study|server|web|tests|bench|docs|examples|src"
FILE = re.compile(rf"(?<![\w/.:<>{{}}-])((?:{FOLDERS})/[\w./-]*\w\.(?:py|js|css|json|md|svg|html|toml))\b")
MODULE = re.compile(r"(?<![\w./-])((?:movingout|bench|tests)(?:\.[A-Za-z_]\w*)+)")
BENCHMARK = re.compile(r"python -m bench ([a-z_]+)")
OTHER_NAMES = ("movingout.v1", "movingout.admin", "movingout.families", "movingout.metrics", "movingout.layout")
"""The protocol, a key of the browser storage, groups of entry points, a key of files."""


def files_of(text: str) -> set[str]:
    """Paths of files; a stem in capitals, as in `maps/NAME.json`, is a placeholder."""
    return {file for file in FILE.findall(text) if not Path(file).stem.isupper()}


def modules_of(text: str) -> set[str]:
    named = {name for name in MODULE.findall(text) if not name.startswith(OTHER_NAMES)}
    return named | {f"bench.{name}" for name in BENCHMARK.findall(text)}


def exists(name: str) -> bool:
    """Whether a dotted name is a module, or something in one."""
    module, _, attribute = name.rpartition(".")
    try:
        if importlib.util.find_spec(name):
            return True
    except ModuleNotFoundError:
        pass
    return bool(module) and exists(module) and hasattr(importlib.import_module(module), attribute)


@pytest.mark.parametrize("page", PAGES)
def test_what_a_page_names_exists(page: str) -> None:
    text = (ROOT / page).read_text(encoding="utf-8")
    assert [file for file in sorted(files_of(text)) if not (ROOT / file).exists()] == []
    assert [name for name in sorted(modules_of(text)) if not exists(name)] == []


def test_what_the_sources_name_exists() -> None:
    pages = (".py", ".js", ".md")
    named = {
        (str(source), file) for source in SOURCES for file in files_of((ROOT / source).read_text(encoding="utf-8"))
    }
    assert {(source, file) for source, file in named if file.endswith(pages) and not (ROOT / file).exists()} == set()


def test_a_name_that_is_gone_is_found() -> None:
    text = "`world/no_such.py`, `movingout.world.no_such`, `movingout.world.World`, python -m bench nothing"
    assert files_of(text) == {"world/no_such.py"}
    assert {name for name in modules_of(text) if not exists(name)} == {"movingout.world.no_such", "bench.nothing"}
