"""What a fresh checkout asks for is what its tools need."""

import json
import re
import shutil
import subprocess

import pytest

from tests.support import ROOT

ESLINT = ROOT / "node_modules/eslint/package.json"


def _accepted(version: str) -> bool:
    """What the check of the Makefile says of a Node of this version."""
    text = (ROOT / "Makefile").read_text(encoding="utf-8")
    found = re.search(r"node -e '([^']+)'", text)
    assert found
    pretend = f'Object.defineProperty(process, "versions", {{ value: {{ node: "{version}" }} }}); {found[1]}'
    return subprocess.run(["node", "-e", pretend], check=False).returncode == 0


@pytest.mark.skipif(not (shutil.which("node") and ESLINT.exists()), reason="without Node and what make check installs")
def test_make_refuses_a_node_that_eslint_does() -> None:
    """`eslint` alone names versions; of the other tools any newer one will do."""
    assert json.loads(ESLINT.read_text(encoding="utf-8"))["engines"]["node"] == "^20.19.0 || ^22.13.0 || >=24"
    right = {"20.18.3": False, "20.19.0": True, "21.7.0": False, "22.12.0": False, "22.13.1": True, "24.0.0": True}
    assert {version: _accepted(version) for version in right} == right


@pytest.mark.parametrize("page", ["README.md", "CONTRIBUTING.md", "Makefile"])
def test_the_pages_name_that_node(page: str) -> None:
    text = " ".join((ROOT / page).read_text(encoding="utf-8").split())
    assert "Node 20.19, 22.13, or 24 and newer, with npm" in text


def test_make_help_lists_the_commands() -> None:
    said = subprocess.run(["make", "help"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    assert "play                    serve the game and print its links\n" in said
