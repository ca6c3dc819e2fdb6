"""The wheel as a stranger meets it: built, installed without our constraints, used outside the repository, beside
another distribution and a folder that have names like ours.
"""

import json
import os
import signal
import subprocess
import sys
import urllib.request
import zipfile
from pathlib import Path

import pytest

from movingout.agents.checkpoint.checkpoint import SHIPPED, readable_checkpoints
from tests.support import ROOT

pytestmark = pytest.mark.slow
PACKAGES = {"agents", "maps", "matches", "recordings", "server", "study", "web", "world"}
LARGEST_MB = 13  # docs/deploy.md says how large it is
LARGEST_SERVING_MB = 300  # in site-packages, byte code included
CLIENT = """from movingout import World, load_map

world = World(load_map("HandOff"))
world.step([[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
print(f"{world.score():.1f}", world.state().robot_poses.shape)
"""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    _run([sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "-w", str(folder), str(ROOT)], folder)
    return next(folder.glob("*.whl"))


@pytest.fixture(scope="module")
def bin_folder(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Programs of a fresh environment: the wheel without constraints, and a distribution whose package is `agents`."""
    home = tmp_path_factory.mktemp("environment")
    _run([sys.executable, "-m", "venv", str(home / "venv")], home)
    programs = home / "venv" / "bin"
    _run([str(programs / "pip"), "install", "--quiet", f"{wheel}[simulate]", "openai-agents"], home)
    return programs


@pytest.fixture
def elsewhere(tmp_path: Path) -> Path:
    """A folder outside the repository, with a package `agents` of its own that fails when it is imported."""
    (tmp_path / "agents").mkdir()
    (tmp_path / "agents" / "__init__.py").write_text("raise RuntimeError('the wrong agents')\n")
    return tmp_path


def test_everything_lies_under_one_name(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
    assert {name.split("/")[0] for name in names if ".dist-info/" not in name} == {"movingout"}
    assert {name.split("/")[1] for name in names if name.count("/") > 1} >= PACKAGES
    assert {"movingout/py.typed", "movingout/web/lobby/index.html", "movingout/maps/HandOff.json"} <= set(names)
    assert not [name for name in names if "/tests/" in name or name.endswith((".pyc", ".safetensors"))]


def test_the_wheel_is_small_and_has_every_agent(wheel: Path) -> None:
    assert wheel.stat().st_size < LARGEST_MB * 1e6
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
    for checkpoint in readable_checkpoints(SHIPPED):
        own = [entry.name for entry in checkpoint.card.files if entry.of is None and entry.name.endswith(".onnx")]
        assert {f"movingout/agents/checkpoints/{checkpoint.folder.name}/{name}" for name in own} <= names


def test_serving_takes_little_room(wheel: Path, tmp_path: Path) -> None:
    """What pip installs beside itself for the wheel without extras, in the versions of the constraints."""
    _run([sys.executable, "-m", "venv", str(tmp_path / "venv")], tmp_path)
    (packages,) = (tmp_path / "venv").glob("lib/python3*/site-packages")
    before = _bytes(packages)
    pip = [str(tmp_path / "venv" / "bin" / "pip"), "install", "--quiet", "--compile"]
    _run([*pip, "-c", str(ROOT / "constraints.txt"), str(wheel)], tmp_path)
    assert _bytes(packages) - before < LARGEST_SERVING_MB * 1e6


def test_a_client_of_five_lines_runs_and_is_typed(bin_folder: Path, elsewhere: Path) -> None:
    (elsewhere / "client.py").write_text(CLIENT)
    assert _run([str(bin_folder / "python"), "client.py"], elsewhere) == "0.0 (2, 3)\n"
    mypy = [sys.executable, "-m", "mypy", "--strict", "--python-executable", str(bin_folder / "python"), "client.py"]
    assert "no issues found" in _run(mypy, elsewhere)


def test_the_version_is_said(bin_folder: Path, elsewhere: Path) -> None:
    assert _run([str(bin_folder / "movingout"), "--version"], elsewhere) == "movingout 0.1.0\n"


def test_golden_episodes_replay_bit_for_bit(bin_folder: Path, elsewhere: Path) -> None:
    golden = ROOT / "tests" / "world"
    script = ROOT / "tests" / "packaging" / "replay_golden.py"
    arguments = [
        str(bin_folder / "python"),
        "-P",
        str(script),
        str(golden / "golden_episode.py"),
        str(golden / "golden"),
    ]
    assert "different: []" in _run(arguments, elsewhere)


def test_a_match_is_played_and_verified(bin_folder: Path, elsewhere: Path) -> None:
    command = [str(bin_folder / "movingout"), "match", "--red", "scripted", "--blue", "mlp@all", "--map", "HandOff"]
    out = _run([*command, "--ticks", "40", "--workers", "2", "--record", "played", "--json"], elsewhere)
    assert json.loads(out)["results"][0]["map"] == "HandOff"
    assert "identical" in _run([str(bin_folder / "movingout"), "recordings", "verify", "played"], elsewhere)
    _run([str(bin_folder / "movingout"), "recordings", "report", "played", "-o", "report.html"], elsewhere)
    assert "<h2>Results by map</h2>" in (elsewhere / "report.html").read_text(encoding="utf-8")


def test_a_server_answers_with_its_pages_and_agents(bin_folder: Path, elsewhere: Path) -> None:
    with _serving(bin_folder, elsewhere) as link:
        with urllib.request.urlopen(link, timeout=20) as page:
            assert b"/static/lobby/lobby.js" in page.read()
        with urllib.request.urlopen(f"{link}api/agents", timeout=20) as answer:
            assert "bass@all" in answer.read().decode()


def test_a_study_is_rehearsed(bin_folder: Path, elsewhere: Path) -> None:
    movingout = str(bin_folder / "movingout")
    _run([movingout, "study", "new", "--template", "agent_survey", "-o", "study.yaml"], elsewhere)
    simulate = [movingout, "study", "simulate", "study.yaml", "--participants", "2", "--speed", "max"]
    _run([*simulate, "--data", "rehearsal"], elsewhere, seconds=400)


def _bytes(folder: Path) -> int:
    return sum(path.lstat().st_size for path in folder.rglob("*") if path.is_file())


def _run(command: list[str], folder: Path, seconds: float = 600) -> str:
    environment = {key: value for key, value in os.environ.items() if key not in ("PYTHONPATH", "PYTHONSAFEPATH")}
    done = subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, timeout=seconds, check=False
    )
    assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
    return done.stdout


class _serving:
    """`movingout play` on any free port; the value is the lobby's address."""

    def __init__(self, programs: Path, folder: Path) -> None:
        environment = {**os.environ, "PYTHONUNBUFFERED": "1"}
        environment.pop("PYTHONPATH", None)
        command = [str(programs / "movingout"), "play", "--port", "0", "--data", "data"]
        self._process = subprocess.Popen(command, cwd=folder, env=environment, stdout=subprocess.PIPE, text=True)

    def __enter__(self) -> str:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            words = [word for word in line.split() if word.startswith("http://127.0.0.1:")]
            if words:
                return words[0].rstrip("/") + "/"
        raise AssertionError("the server ended without printing a link")

    def __exit__(self, *_: object) -> None:
        self._process.send_signal(signal.SIGINT)
        self._process.wait(20)
        if self._process.stdout is not None:
            self._process.stdout.close()
