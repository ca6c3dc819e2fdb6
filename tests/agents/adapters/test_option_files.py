"""Which files and folders count as an agent's weights."""

import hashlib
from pathlib import Path

import pytest

from movingout.agents.adapters.option_files import file_fingerprint


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "weights").mkdir()
    for name in ("p.zip", "stats.pkl", "weights/a", "greedy", "007", "2026"):
        (tmp_path / name).write_bytes(name.encode())
    return tmp_path


@pytest.mark.parametrize(
    ("agent_id", "file"),
    [
        ("sb3:path=p.zip,normalize=stats.pkl", "stats.pkl"),
        ("sb3:normalize=stats.pkl,path=p.zip", "p.zip"),
        ("mine:Agent:path=weights", "weights/a"),
        ("mine:Agent:path=weights", "weights/b"),
        ("installed:path=p.zip,speed=2", "p.zip"),
        ("ghost:p.zip#red", "p.zip"),
        ("torchscript:path=007", "007"),  # a name that is a number
        ("mine:Agent:path=2026", "2026"),
    ],
)
def test_each_file_that_an_option_names_counts(agent_id: str, file: str, folder: Path) -> None:
    before = file_fingerprint(agent_id)
    (folder / file).write_bytes(b"other")
    assert len(before) == 64 and file_fingerprint(agent_id) not in (before, "")


def test_a_single_file_has_the_hash_that_it_has_in_folders_of_before(folder: Path) -> None:
    for agent_id in ("onnx:path=p.zip", "sb3:path=p.zip,normalize=none.pkl", "mine:Agent:path=p.zip"):
        assert file_fingerprint(agent_id) == hashlib.sha256(b"p.zip").hexdigest()


@pytest.mark.parametrize(
    "agent_id",
    [
        "mine:Agent",
        "mine:Agent:speed=2",
        "mine:Agent:path=.",  # which results are written into
        f"mine:Agent:text={'x' * 300}",
        "mine:Agent:path",
        "late:agent=greedy",  # the agent, not the file of that name
        "dp@all:path=p.zip",
        "ghost:none.mcap#red",
    ],
)
def test_an_agent_without_such_options_has_none(agent_id: str, folder: Path) -> None:
    assert file_fingerprint(agent_id) == ""


def test_what_python_writes_beside_code_does_not_count(folder: Path) -> None:
    before = file_fingerprint("mine:Agent:path=weights")
    (folder / "weights/__pycache__").mkdir()
    (folder / "weights/__pycache__/mine.pyc").write_bytes(b"x")
    assert file_fingerprint("mine:Agent:path=weights") == before
