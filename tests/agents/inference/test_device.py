"""The device that networks run on is asked for in the environment, and refused in a sentence where there is none."""

import os
import subprocess
import sys
from pathlib import Path

import onnxruntime
import pytest

from movingout.agents.errors import AgentError
from movingout.agents.inference.device import VARIABLE, providers
from movingout.agents.inference.network import Network

NOT_INHERITED = "ORT_DISABLE_TELEMETRY", "CI", "TF_BUILD", "GITHUB_ACTIONS", "XDG_CACHE_HOME"


def test_no_network_is_reported_to_the_makers_of_onnxruntime(tmp_path: Path) -> None:
    """Its telemetry would begin with an identifier in a new home, unless it runs in continuous integration."""
    environment = {key: value for key, value in os.environ.items() if key not in NOT_INHERITED}
    script = "from movingout import load_agent; load_agent('mlp@all')"
    subprocess.run([sys.executable, "-c", script], check=True, env={**environment, "HOME": str(tmp_path)}, timeout=120)
    assert list(tmp_path.rglob("*")) == []


def test_without_a_wish_it_is_the_processor(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(VARIABLE, raising=False)
    assert providers() == ["CPUExecutionProvider"]


def test_a_gpu_is_taken_where_onnxruntime_has_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, "cuda")
    both = ["CUDAExecutionProvider", "CPUExecutionProvider"]
    monkeypatch.setattr(onnxruntime, "get_available_providers", lambda: both)
    assert providers() == both


@pytest.mark.parametrize(("device", "sentence"), [("cuda", "install onnxruntime-gpu"), ("tpu", "run on cpu or cuda")])
def test_what_is_not_there_is_refused(device: str, sentence: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, device)
    monkeypatch.setattr(onnxruntime, "get_available_providers", lambda: ["CPUExecutionProvider"])
    with pytest.raises(AgentError, match=sentence):
        providers()


def test_a_network_is_refused_with_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, "tpu")
    with pytest.raises(AgentError, match="run on cpu or cuda"):
        Network(b"")
