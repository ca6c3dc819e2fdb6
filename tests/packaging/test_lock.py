"""constraints/serving.txt: what a server installs, by version and hash; files that say they are complete are."""

import re
from importlib.metadata import requires, version

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tests.support import ROOT

LOCK = (ROOT / "constraints/serving.txt").read_text(encoding="utf-8")
ENTRY = re.compile(
    r"^(?P<name>[\w.-]+)==(?P<version>[^ ;]+)[^\n]*\\\n(?P<hashes>(?:    --hash=sha256:[0-9a-f]{64}(?: \\)?\n)+)", re.M
)
LOCKED: dict[str, str] = {canonicalize_name(entry["name"]): entry["version"] for entry in ENTRY.finditer(LOCK)}


def _constraints(file: str = "constraints.txt") -> dict[str, str]:
    lines = (ROOT / file).read_text(encoding="utf-8").splitlines()
    pairs = [line.split("==") for line in lines if "==" in line and not line.startswith("#")]
    return {canonicalize_name(name): pinned.partition(";")[0].strip() for name, pinned in pairs}


def _needed(name: str, extra: str = "") -> set[str]:
    """What a distribution requires here, with everything that requires in turn."""
    found: set[str] = set()
    waiting = [(name, extra)]
    while waiting:
        one, chosen = waiting.pop()
        for text in requires(one) or []:
            wanted = Requirement(text)
            if wanted.marker is not None and not wanted.marker.evaluate({"extra": chosen}):
                continue
            key = canonicalize_name(wanted.name)
            if key not in found:
                found.add(key)
                waiting += [(key, each) for each in ("", *wanted.extras)]
    return found


def test_every_line_is_a_version_with_hashes_and_names_no_address() -> None:
    entries = "".join(entry.group(0) for entry in ENTRY.finditer(LOCK))
    comments = "".join(line for line in LOCK.splitlines(keepends=True) if line.startswith("#"))
    assert comments + entries == LOCK
    assert "://" not in LOCK and "index" not in entries


def test_versions_are_those_of_the_constraints() -> None:
    constraints = _constraints()
    assert {name: constraints.get(name) for name in LOCKED} == LOCKED


def test_all_that_a_server_needs_is_locked_as_it_is_installed() -> None:
    needed = _needed("moving-out-live") | _needed("moving-out-live", "postgres")
    assert needed and needed <= LOCKED.keys()
    assert {name: version(name) for name in needed} == {name: LOCKED[name] for name in needed}


@pytest.mark.parametrize(
    ("stack", "extras"), [("benchmarl", ("env",)), ("rllib", ("env",)), ("lerobot", ("export", "video"))]
)
def test_a_stack_with_versions_of_its_own_pins_all_that_we_need(stack: str, extras: tuple[str, ...]) -> None:
    needed = _needed("moving-out-live").union(*(_needed("moving-out-live", extra) for extra in extras))
    assert needed - _constraints(f"constraints/{stack}.txt").keys() == set()
