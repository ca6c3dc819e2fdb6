"""When results may differ from the official benchmark, and that the commands say so."""

import importlib.metadata
import platform
import socket
from pathlib import Path

import pytest

from movingout.server.cli import main
from movingout.world.exactness import inexact_engine


@pytest.mark.parametrize("version", ["6.8.0", "6.8.1", "6.11.1"])
def test_known_versions_are_exact_on_x86_linux(monkeypatch: pytest.MonkeyPatch, version: str) -> None:
    _pretend(monkeypatch, version)
    assert inexact_engine() is None


@pytest.mark.parametrize("version", ["6.7.0", "6.11.2", "7.0.0"])
def test_other_versions_are_named(monkeypatch: pytest.MonkeyPatch, version: str) -> None:
    _pretend(monkeypatch, version)
    assert inexact_engine() == (
        f"physics are not exact: pymunk {version} is outside 6.8.0 to 6.11.1; install pymunk 6.11.1 for exact results"
    )


def test_another_platform_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    _pretend(monkeypatch, "6.11.1", "Darwin", "arm64")
    assert str(inexact_engine()).endswith("this is Darwin arm64")


def test_a_match_says_on_standard_error_that_the_engine_is_not_exact(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    _pretend(monkeypatch, "7.0.0")
    words = "match", "--red", "idle", "--blue", "idle", "--map", "HandOff", "--ticks", "2", "--workers", "1"
    assert main(list(words)) == 0
    assert "movingout: physics are not exact: pymunk 7.0.0" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["play", "study serve --rehearse 1 study.yaml"])
def test_a_server_says_it_before_anybody_plays(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path, command: str
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["study", "new", "-o", "study.yaml"]) == 0
    _pretend(monkeypatch, "7.0.0")
    with socket.create_server(("127.0.0.1", 0)) as taken:  # so that the server ends at once
        port = str(taken.getsockname()[1])
        assert main([*command.split(), "--data", "data", "--port", port]) != 0
    assert "movingout: physics are not exact: pymunk 7.0.0" in capsys.readouterr().err


def _pretend(monkeypatch: pytest.MonkeyPatch, version: str, system: str = "Linux", machine: str = "x86_64") -> None:
    known = importlib.metadata.version
    monkeypatch.setattr(importlib.metadata, "version", lambda name: version if name == "pymunk" else known(name))
    monkeypatch.setattr(platform, "system", lambda: system)
    monkeypatch.setattr(platform, "machine", lambda: machine)
