import hashlib
import json
import time
from pathlib import Path

import pytest

from movingout.agents.catalogue import load_agent
from movingout.agents.data.rollout import rollout
from movingout.maps import load_map, map_to_json
from movingout.matches.execution.lockstep import Lockstep
from movingout.matches.match import Match, MatchResult, result_from_json
from movingout.recordings import read_episode, verify
from movingout.world.metrics import EpisodeMetrics
from tests.matches.support import HERE, Fleet

BAD = "tests.agents.support"


def _matches(blue: str, count: int = 4, ticks: int = 60, red: str = f"{HERE}:Wanderer") -> list[Match]:
    return [Match("DistancePriority", blue, red, seed, ticks=ticks) for seed in range(count)]


def _by_seed(results: list[MatchResult]) -> list[MatchResult]:
    return sorted(results, key=lambda result: result.match.seed)


def test_a_match_gives_what_the_plain_rollout_gives() -> None:
    (match,) = _matches(f"{HERE}:Wanderer", 1)
    (result,) = Lockstep().play([match])
    metrics = EpisodeMetrics(match.world_map())
    for step in rollout(match.world_map(), (load_agent(match.blue), load_agent(match.red)), match.seed, match.ticks):
        metrics.update(step.before, step.actions, step.after)
    expected = metrics.result()
    assert result.metrics == expected
    assert expected.nfd != 0.0


@pytest.mark.parametrize("batch_size", [1, 3, 16])
def test_a_result_does_not_depend_on_the_matches_beside_it(batch_size: int) -> None:
    alone = [result for match in _matches(f"{HERE}:Wanderer") for result in Lockstep().play([match])]
    assert _by_seed(list(Lockstep(batch_size=batch_size).play(_matches(f"{HERE}:Wanderer")))) == alone
    assert len({(result.metrics.nfd, result.metrics.wt_s) for result in alone}) > 1, (
        "the seeds must differ, else this shows nothing"
    )


@pytest.mark.slow
@pytest.mark.parametrize("pair", [("scripted", "scripted"), ("person:name=C01", "dp@all")])
def test_what_shipped_agents_remember_of_other_matches_changes_nothing(pair: tuple[str, str]) -> None:
    matches = [Match("DistancePriority", *pair, seed, ticks=60) for seed in range(3)]
    together = _by_seed(list(Lockstep().play(matches)))
    assert together == [result for match in matches for result in Lockstep().play([match])]


def test_agents_that_can_are_asked_in_one_batch_with_the_same_result() -> None:
    Fleet.sizes.clear()
    together = _by_seed(list(Lockstep().play(_matches(f"{HERE}:Fleet", red=f"{HERE}:Fleet"))))
    assert set(Fleet.sizes) == {8}
    alone = Lockstep().play(_matches(f"{HERE}:Wanderer"))
    assert [one.metrics for one in together] == [one.metrics for one in _by_seed(list(alone))]


@pytest.mark.parametrize("red", ["Stumbling", "Wanderer"])
def test_who_fails_in_a_batch_loses_its_match_and_no_other(red: str, tmp_path: Path) -> None:
    """The whole batch failed, so that results depended on its size."""
    matches = _matches(f"{HERE}:Stumbling", 5, red=f"{HERE}:{red}")
    alone = list(Lockstep(batch_size=1).play(matches))
    together = list(Lockstep(record=tmp_path).play(matches))
    assert _by_seed(together) == alone
    assert [result.ending for result in alone] == ["time", "failed", "time", "failed", "time"]
    assert {result.failure.partition(" (")[0] for result in alone if result.failure} == {"blue"}
    assert sorted(tmp_path.iterdir()) == sorted(Path(result.recording) for result in together)
    assert all(verify(Path(result.recording)).identical for result in together)


@pytest.mark.parametrize(
    ("agent", "reason"),
    [
        (f"{BAD}:Raising", "blue (tests.agents.support:Raising) raised ValueError in act() at tick 1: I do not know"),
        (f"{BAD}:NotANumber", "its answer at tick 1: an action chunk must hold finite numbers"),
        (f"{HERE}:Keyless", "blue (tests.matches.support:Keyless) raised ValueError in reset(): no key"),
        (f"{HERE}:Listed", "blue (tests.matches.support:Listed), reset(): batch_key is no value that can be hashed"),
        (
            f"{HERE}:Rowless",
            "blue (tests.matches.support:Rowless), its answer at tick 0: execute_rows is None; it is a whole number",
        ),
        (
            f"{HERE}:Interrupting",
            "blue (tests.matches.support:Interrupting) raised KeyboardInterrupt in act() at tick 0",
        ),
        (f"{BAD}:broken_factory", "could not be made: RuntimeError: no weights here"),
        (f"{HERE}:Late", "blue (tests.matches.support:Late) did not answer act() at tick 8 within 0.2 s"),
    ],
)
def test_an_agent_that_misbehaves_loses_its_match_and_no_other(agent: str, reason: str) -> None:
    good = _matches(f"{HERE}:Wanderer", 2)
    bad = Match("DistancePriority", agent, f"{HERE}:Wanderer", 9, ticks=60)
    results = {result.match: result for result in Lockstep(agent_limit_s=0.2).play([good[0], bad, good[1]])}
    lost = results[bad]
    assert (lost.ending, lost.failed_seat, lost.metrics.tcr, lost.metrics.wt_s) == ("failed", 0, 0.0, None)
    assert reason in lost.failure
    assert [results[match] for match in good] == _by_seed(list(Lockstep().play(good)))


def test_a_map_with_more_than_the_agent_sees_is_refused_in_its_own_words(tmp_path: Path) -> None:
    crowded = map_to_json(load_map("HandOff")) | {"name": "Crowded"}
    crowded["goals"] = [{"x0": -1.2 + 0.4 * k, "y0": 1.2, "x1": -0.9 + 0.4 * k, "y1": 0.6} for k in range(5)]
    (tmp_path / "crowded.json").write_text(json.dumps(crowded))
    (result,) = Lockstep().play([Match(str(tmp_path / "crowded.json"), "mlp@all", "idle", 0, ticks=4)])
    assert result.failure == "blue (mlp@all), reset(): the layout aware-v1 has 4 slots for goals; Crowded has 5"


def test_a_recorded_match_re_simulates_to_the_bit(tmp_path: Path) -> None:
    (result,) = Lockstep(record=tmp_path).play(_matches(f"{HERE}:Wanderer", 1))
    path = Path(result.recording)
    assert verify(path).identical
    episode = read_episode(path)
    assert (episode.outcome, len(episode.ticks), episode.header.source) == ("time", 60, "match")
    assert [event.kind for event in episode.events][:: len(episode.events) - 1] == ["start", "end"]


def test_a_recording_keeps_what_agents_say_about_each_answer_or_why_it_cannot_be_written(tmp_path: Path) -> None:
    match = Match("DistancePriority", f"{HERE}:Talker", f"{HERE}:Mumbler", 4, ticks=12)
    (result,) = Lockstep(record=tmp_path).play([match])
    decisions = read_episode(Path(result.recording)).decisions
    blue, red = ([decision for decision in decisions if decision.seat == seat] for seat in (0, 1))
    assert [decision.tick for decision in blue] == [1, 5, 9]  # chunks of four rows
    assert [decision.detail for decision in blue] == [{"heard": tick - 1} for tick in (1, 5, 9)]
    assert {str(decision.detail) for decision in red} == {
        "{'unwritable': 'TypeError: Type is not JSON serializable: Mumbler'}"
    }
    assert {decision.latency_ms for decision in decisions} == {-1.0}


def test_the_recording_of_a_trained_agent_has_its_card_and_hash(tmp_path: Path) -> None:
    (result,) = Lockstep(record=tmp_path).play([Match("HandOff", "dp@all", "idle", 1, ticks=2)])
    episode = read_episode(Path(result.recording))
    card = episode.attachments["card-blue.json"]
    assert episode.header.seats[0].checkpoint_sha256 == hashlib.sha256(card).hexdigest()
    assert episode.attachments.keys() == {"map.json", "card-blue.json"}


@pytest.mark.parametrize("agent", ["Raising", "NotUtf8", "NotUtf8AgentError"])
def test_the_recording_of_a_lost_match_says_who_lost_it(agent: str, tmp_path: Path) -> None:
    (result,) = Lockstep(record=tmp_path).play(_matches(f"{BAD}:{agent}", 1))
    episode = read_episode(Path(result.recording))
    assert episode.outcome == "error"
    assert [(event.seat, event.detail) for event in episode.events if event.kind == "agent_error"] == [
        (0, result.failure)
    ]


def test_challenge_2_plays_a_variant_that_the_seed_makes() -> None:
    maps = [Match("HandOff", "idle", "idle", seed, challenge=2).world_map() for seed in (0, 0, 1)]
    assert maps[0] == maps[1] != maps[2]
    assert maps[0].variant == "challenge2-evaluation-0"


def test_a_sign_of_life_comes_while_agents_think() -> None:
    beats: list[float] = []
    lockstep = Lockstep(heartbeat=lambda: beats.append(time.monotonic()))
    lockstep._timer._last_heartbeat -= 10
    list(lockstep.play(_matches(f"{HERE}:Wanderer", 1)))
    assert len(beats) == 1


def test_results_keep_what_agents_counted_but_those_of_before() -> None:
    (result,) = Lockstep().play([Match("DistancePriority", "idle", f"{HERE}:Counting", 0, ticks=8)])
    document = json.loads(json.dumps(result.to_json()))
    assert result_from_json(document).counts == {"red_questions": 4, "red_useful": 1}
    del document["counts"]
    assert result_from_json(document).counts == {}
    (lost,) = Lockstep().play([Match("DistancePriority", f"{HERE}:Absent", "idle", 0, ticks=8)])
    assert lost.failure.startswith(f"blue ({HERE}:Absent) raised ValueError in its account: no account")


def test_a_result_survives_its_own_json() -> None:
    for result in Lockstep().play([*_matches(f"{BAD}:Raising", 1), *_matches("idle", 1)]):
        assert result_from_json(result.to_json()) == result


def test_results_have_the_action_consistency_of_the_official_code_but_those_of_before() -> None:
    scripted = Match("SingleRotation", "scripted", "scripted", 0, ticks=120)
    failed, alone, together = Lockstep().play([*_matches(f"{BAD}:Raising", 1), *_matches("idle", 1), scripted])
    assert failed.official_ac is None and alone.official_ac is None
    assert together.official_ac is not None and 0.0 < together.official_ac <= 1.0
    document = together.to_json()
    assert result_from_json(document).official_ac == together.official_ac
    del document["official_ac"]
    assert result_from_json(document).official_ac is None
