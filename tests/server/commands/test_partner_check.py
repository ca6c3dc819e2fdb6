"""The partner that the lobby proposes is tried at the start, on a map that it will meet."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from movingout.agents.errors import AgentError
from movingout.maps import load_map, map_to_json
from movingout.server.commands.partner_check import check_partner

AGENT = """
import numpy as np

class OnlyOwn:
    def reset(self, episode):
        if episode.map.name != "Own":
            raise ValueError(f"I know Own, not {episode.map.name}")

    def act(self, observation):
        return np.array([[0.0, 1.0, 0.0, 0.0]])
"""


def _maps(folder: Path, name: str) -> Path:
    folder.mkdir()
    (folder / "a.json").write_text("no map")
    (folder / "b.json").write_text(json.dumps(map_to_json(load_map("HandOff")) | {"name": name}))
    return folder


def test_an_agent_for_ones_own_maps_alone_is_a_partner(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "only_own.py").write_text(AGENT)
    monkeypatch.chdir(tmp_path)
    said = check_partner("only_own:OnlyOwn", _maps(tmp_path / "maps", "Own"))
    assert said.startswith("the partner only_own:OnlyOwn plays on b.json, but not on every map: ")
    assert "ValueError: I know Own, not HandOff (only_own.py" in said
    with pytest.raises(AgentError, match="I know Own, not HandOff"):
        check_partner("only_own:OnlyOwn", _maps(tmp_path / "others", "Another"))


ENDLESS = """
import threading
import time

import numpy as np

class Endless:
    def __init__(self):
        threading.Thread(target=time.sleep, args=(600,), name="camera").start()

    def reset(self, episode):
        pass

    def act(self, observation):
        return np.array([[0.0, 1.0, 0.0, 0.0]])
"""


POOLED = """
from concurrent.futures import ThreadPoolExecutor

import numpy as np

pool = ThreadPoolExecutor(1)
log = open("agent.log", "w")

class Pooled:
    def reset(self, episode):
        pass

    def act(self, observation):
        pool.submit(print, observation.tick, file=log).result()
        return np.array([[0.0, 1.0, 0.0, 0.0]])
"""


@pytest.mark.slow
@pytest.mark.parametrize("action", ["probe", "check"])
def test_a_command_ends_though_an_agent_leaves_a_thread_running(tmp_path: Path, action: str) -> None:
    (tmp_path / "endless.py").write_text(ENDLESS)
    command = [sys.executable, "-P", "-m", "movingout.server.cli", "agents", action, "endless:Endless"]
    options = ["--ticks", "1", "--map", "HandOff", "--json"]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(tmp_path), *sys.path])}
    ended = subprocess.run([*command, *options], capture_output=True, text=True, env=environment, timeout=60)
    assert ended.returncode == 0
    assert json.loads(ended.stdout)["id"] == "endless:Endless"
    assert "movingout: not waiting for threads that an agent left running: camera\n" in ended.stderr


def test_what_an_agent_keeps_open_is_written_and_its_pool_ends_as_python_ends_it(tmp_path: Path) -> None:
    (tmp_path / "pooled.py").write_text(POOLED)
    command = [sys.executable, "-P", "-m", "movingout.server.cli", "agents", "probe", "pooled:Pooled"]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(tmp_path), *sys.path])}
    options = ["--ticks", "5", "--map", "HandOff"]
    ended = subprocess.run(
        [*command, *options], capture_output=True, text=True, env=environment, cwd=tmp_path, timeout=60
    )
    assert ended.returncode == 0 and "not waiting" not in ended.stderr
    assert (tmp_path / "agent.log").read_text().count("\n") >= 5


def test_a_partner_whose_thread_keeps_its_process_alive_has_played(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    asked: list[object] = []

    def late(*words: object, output: bytes, **__: object) -> None:
        asked.append(words)
        raise subprocess.TimeoutExpired("probe", 90, output)

    monkeypatch.setattr(subprocess, "run", lambda *_, **__: late(output=b'{"holds_10hz": true}\n'))
    assert check_partner("scripted:seed=1") == ""
    asked.clear()
    monkeypatch.setattr(subprocess, "run", lambda *_, **__: late(output=b""))
    with pytest.raises(AgentError, match="the partner scripted:seed=1 was not ready within"):
        check_partner("scripted:seed=1", _maps(tmp_path / "maps", "Only"))
    assert len(asked) == 1  # another map does not make it faster
