"""A match is played once for all tables, and again only with other weights."""

from pathlib import Path

import pytest

from movingout.matches.match import Match, MatchResult, failed_result
from movingout.matches.paper import match_store
from movingout.matches.paper.match_store import MatchStore
from movingout.matches.results import other_code
from movingout.world.metrics import Metrics


def played_result(match: Match) -> MatchResult:
    return MatchResult(match, "time", 60, 0, 4, Metrics.of({"tcr": 0.5, "nfd": 0.5, "wt_s": 1.5, "ac": None}), 0.03)


def test_a_match_is_played_once_and_again_with_other_weights(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    weights = {"dp@a": "1", "dp@b": "2"}
    asked: list[Match] = []

    def play(matches: list[Match], **options: object) -> list[MatchResult]:
        asked.extend(matches)
        for match in matches:
            options["on_result"](played_result(match))  # type: ignore[operator]
        return []

    monkeypatch.setattr(match_store, "fingerprint", lambda agent_id: weights.get(agent_id, ""))
    monkeypatch.setattr(match_store, "play_matches", play)
    one, other = Match("HandOff", "dp@a", "dp@b", 0), Match("HandOff", "dp@b", "dp@a", 0)
    MatchStore(tmp_path).play([one, one], workers=1)
    assert asked == [one]
    store = MatchStore(tmp_path)
    assert store.find(one) == played_result(one) and store.missing([one, other]) == [other]
    store.play([one, other], workers=1)
    assert asked == [one, other] and len(list(tmp_path.iterdir())) == 1, "a pair has one folder, in either order"
    weights["dp@a"] = "3"
    assert MatchStore(tmp_path).missing([one, other]) == [one, other]


def test_what_failed_is_played_again_by_the_next_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Match] = []
    good, lost = Match("HandOff", "idle", "idle", 0), Match("HandOff", "idle", "idle", 1)
    again = failed_result(lost, "lost its worker process 3 times")

    def play(matches: list[Match], **options: object) -> list[MatchResult]:
        asked.extend(matches)
        for match in matches:
            options["on_result"](again if match == lost else played_result(match))  # type: ignore[operator]
        return []

    monkeypatch.setattr(match_store, "play_matches", play)
    store = MatchStore(tmp_path)
    store.play([good, lost], workers=1)
    assert store.missing([good, lost]) == [], "one command tries it once, for all its tables"
    later = MatchStore(tmp_path)
    assert later.find(lost) == again, "until then the tables have it as failed"
    assert later.missing([good, lost]) == [lost] and later.failed_before([good, lost]) == 1
    again = played_result(lost)
    later.play([good, lost], workers=1)
    assert asked == [good, lost, lost] and MatchStore(tmp_path).missing([good, lost]) == []


def test_an_agent_that_is_trained_meanwhile_gets_a_place_of_its_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    weights: dict[str, str] = {}
    monkeypatch.setattr(match_store, "fingerprint", lambda agent_id: weights.get(agent_id, ""))
    monkeypatch.setattr(
        match_store, "play_matches", lambda matches, **how: [how["on_result"](played_result(one)) for one in matches]
    )
    store, match = MatchStore(tmp_path), Match("HandOff", "dp@a", "dp@a", 0)
    assert store.missing([match]) == [match]
    weights["dp@a"] = "1"
    store.play([match], workers=1)
    assert store.find(match) is not None and MatchStore(tmp_path).find(match) is not None


def test_what_other_code_played_is_kept_and_counted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        match_store, "play_matches", lambda matches, **how: [how["on_result"](played_result(one)) for one in matches]
    )
    first, second = Match("HandOff", "idle", "idle", 0), Match("HandOff", "idle", "idle", 1)
    MatchStore(tmp_path).play([first], workers=1)
    store = MatchStore(tmp_path)
    assert store.of_other_code([first, second]) == 0
    monkeypatch.setattr(other_code, "code_sha256", lambda: "other")
    assert store.of_other_code([first, second]) == 1 and store.missing([first, second]) == [second]
    store.play([second], workers=1)
    results = [store.find(first), store.find(second)]
    assert other_code.is_mixed(filter(None, results)) and store.of_other_code([second]) == 0
