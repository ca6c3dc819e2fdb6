"""The partner that the lobby proposes is tried at the start, on a map that it will meet."""

import json
import subprocess
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


def test_a_partner_whose_thread_keeps_its_process_alive_has_played(monkeypatch: pytest.MonkeyPatch) -> None:
    def late(*_: object, output: bytes, **__: object) -> None:
        raise subprocess.TimeoutExpired("probe", 90, output)

    monkeypatch.setattr(subprocess, "run", lambda *_, **__: late(output=b'{"holds_10hz": true}\n'))
    assert check_partner("scripted:seed=1") == ""
    monkeypatch.setattr(subprocess, "run", lambda *_, **__: late(output=b""))
    with pytest.raises(AgentError, match="the partner scripted:seed=1 was not ready within"):
        check_partner("scripted:seed=1")
