"""Finished evaluation episodes: kept, found again, and left alone when somebody would play otherwise now."""

import dataclasses
import json
from pathlib import Path

import pytest

from bench.learning import play_all
from bench.results import episode_log
from bench.results.episode_log import EpisodeLog, Outcome, Run
from movingout.maps.errors import MovingOutError

RUN = Run("idle", "person:name=C01", "HandOff", 0, 1, 3)


def _kept(log: Path, run: Run = RUN) -> EpisodeLog:
    kept = EpisodeLog(log)
    kept.append(Outcome(run, 0.75, 0.5, 1.0, None, 0.1))
    return kept


def test_a_stopped_evaluation_goes_on_from_its_log(tmp_path: Path) -> None:
    log, run = tmp_path / "log.jsonl", Run("idle", "idle", "SingleRotation", 0, 1, 3)
    _kept(log, run)
    assert list(EpisodeLog(log).known([run, Run("idle", "idle", "HandOff", 0, 1, 3)])) == [run]
    assert [one.tcr for one in play_all([run], 1, log)] == [0.75]


@pytest.mark.parametrize("part", ["code_sha256", "_version"])
def test_a_log_is_of_no_use_when_the_code_or_an_agent_is_another(
    part: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    log = tmp_path / "log.jsonl"
    assert RUN in _kept(log).known([RUN])
    monkeypatch.setattr(episode_log, part, lambda *_: "changed")
    assert not EpisodeLog(log).known([RUN])


def test_a_log_of_an_earlier_version_is_still_known(tmp_path: Path) -> None:
    log = tmp_path / "log.jsonl"
    _kept(log)
    entry = json.loads(log.read_text())
    del entry["outcome"]["interdependence"], entry["outcome"]["run"]["challenge"]
    assert "challenge" not in json.loads(entry["key"])
    log.write_text(json.dumps(entry) + "\n")
    assert EpisodeLog(log).known([RUN])[RUN].interdependence is None
    assert not EpisodeLog(log).known([dataclasses.replace(RUN, challenge=2)])


def test_a_module_of_somebody_else_counts_by_its_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    versions = []
    for text in ("one", "two"):
        (tmp_path / "their_agent.py").write_text(f"NAME = {text!r}")
        episode_log._version.cache_clear()
        versions.append(episode_log._version("their_agent:Agent"))
    assert versions[0] != versions[1] and episode_log._version("idle") == ""
    episode_log._version.cache_clear()


def test_what_is_left_of_a_line_is_passed_over_and_other_files_are_refused(tmp_path: Path) -> None:
    log = tmp_path / "log.jsonl"
    _kept(log)
    whole = log.read_bytes()
    log.write_bytes(whole + whole[: len(whole) // 2])
    other = Run("idle", "idle", "HandOff", 0, 1, 3)
    _kept(log, other)
    assert set(EpisodeLog(log).known([RUN, other])) == {RUN, other}
    for text in ("torn", "{}\n", "[1]\n"):
        log.write_text(text)
        with pytest.raises(MovingOutError, match="is not a log of finished episodes"):
            EpisodeLog(log)
        assert log.read_text() == text


def test_two_who_keep_their_episodes_in_one_file_lose_none(tmp_path: Path) -> None:
    log, other = tmp_path / "log.jsonl", Run("idle", "idle", "HandOff", 0, 1, 3)
    one, two = EpisodeLog(log), EpisodeLog(log)
    one.append(Outcome(RUN, 0.75, 0.5, 1.0, None, 0.1))
    two.append(Outcome(other, 0.5, 0.5, 1.0, None, 0.1))
    assert set(EpisodeLog(log).known([RUN, other])) == {RUN, other}
