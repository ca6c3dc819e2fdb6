"""The distribution: its top-level names are ours, serving is free of torch, help is quick to import."""

import importlib
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import yaml

import movingout
from tests.support import ROOT

PACKAGES = ("maps", "world", "recordings", "agents", "matches", "study", "server", "web")


@pytest.mark.parametrize("name", PACKAGES)
def test_a_package_of_the_namespace_is_the_folder_at_the_top(name: str) -> None:
    module = importlib.import_module(f"movingout.{name}")
    assert Path(str(module.__file__)).resolve() == ROOT / name / "__init__.py"


@pytest.mark.parametrize("name", ["admin-token", "serving.lock", "data/admin-token", "own/identity.sqlite"])
def test_what_a_server_keeps_in_its_data_folder_stays_out_of_the_repository(name: str) -> None:
    """An admin token was in it once: `play --data .` in a checkout would have taken one that everybody knows."""
    if not (ROOT / ".git").exists():
        pytest.skip("this copy is no repository")
    assert subprocess.run(["git", "check-ignore", "--quiet", "--no-index", name], cwd=ROOT).returncode == 0
    tracked = subprocess.run(["git", "ls-files", name], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    assert tracked == ""


def test_the_package_says_of_itself_what_its_citation_says() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    for field in ("version", "license", "keywords", "authors"):
        assert project[field] == citation[field], field


def test_make_clean_removes_caches_and_what_was_built() -> None:
    """All folders that the repository ignores, but for data and what lies beside each module."""
    ignored = (ROOT / ".gitignore").read_text(encoding="utf-8").split()
    folders = {line.rstrip("/") for line in ignored if line.endswith("/")} - {"/data", "__pycache__"}
    recipe = (ROOT / "Makefile").read_text(encoding="utf-8").partition("\nclean:")[2].split("\n\n")[0]
    assert {folder for folder in folders if folder not in recipe} == set()


def test_the_public_names_exist_and_are_documented() -> None:
    for name in set(movingout.__all__) - {"__version__"}:
        assert getattr(movingout, name).__doc__, name
    assert set(movingout.__all__) <= set(dir(movingout))


def test_an_unknown_public_name_is_answered_with_the_known_ones() -> None:
    with pytest.raises(AttributeError, match=r"no attribute 'load_maps'.*load_map"):
        _ = movingout.load_maps


def test_the_namespace_costs_nothing_until_a_name_is_used() -> None:
    assert not _modules_after("import movingout") & {"numpy", "pymunk", "movingout.world"}


def _modules_after(statement: str) -> set[str]:
    program = f"{statement}\nimport sys; print(' '.join(sys.modules))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    return set(done.stdout.split())


def test_the_server_never_imports_torch() -> None:
    modules = _modules_after("import movingout.server.app")
    assert "movingout.server.app" in modules
    assert not modules & {"torch", "onnxruntime", "viser"}


def test_help_imports_no_heavy_library() -> None:
    modules = _modules_after("import movingout.server.cli")
    assert "movingout.server.cli" in modules
    assert not modules & {"pymunk", "numpy", "fastapi", "torch", "mcap", "rich"}


def test_a_wrong_command_is_answered_with_the_known_ones_and_exit_code_2() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "movingout.server.cli", "plya"], capture_output=True, text=True, cwd=ROOT
    )
    assert done.returncode == 2
    assert done.stderr.startswith("movingout: unknown command 'plya'; did you mean play? known: play, match,")


def test_the_version_is_the_packages() -> None:
    done = subprocess.run([sys.executable, "-m", "movingout.server.cli", "--version"], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, f"movingout {movingout.__version__}\n")


def test_our_own_processes_do_not_import_from_the_folder_they_are_started_in() -> None:
    """Without `-P`, a folder `agents` or `movingout` where somebody stands would be imported instead of ours.

    `maps/extras.py` only says what to type.
    """
    sources = {path: path.read_text(encoding="utf-8") for name in PACKAGES for path in (ROOT / name).rglob("*.py")}
    starting = {path for path, text in sources.items() if "sys.executable" in text and path.name != "extras.py"}
    assert len(starting) >= 5
    assert {path for path in starting if '"-P"' not in sources[path]} == set()


def test_constraints_are_plain_pins() -> None:
    lines = (ROOT / "constraints.txt").read_text().splitlines()
    pins = [line for line in lines if line and not line.startswith("#")]
    assert all(line.count("==") == 1 and " " not in line and "://" not in line for line in pins)
    assert {"pymunk==6.11.1", "torch==2.13.0"} <= set(pins)
