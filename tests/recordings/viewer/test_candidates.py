"""What an agent considered, read from what it told."""

import math
from pathlib import Path

import numpy as np
import pytest

from movingout.maps import load_map
from movingout.recordings import AgentDecision
from movingout.recordings.meshes import SEAT_RGB
from movingout.recordings.viewer.candidates import CHOSEN_RGB, Decisions, candidate_lines, candidates, guesses
from movingout.world import World
from tests.recordings.viewer.support import panel, put, recorded

START = World(load_map("HandOff")).state()


def decision(tick: int, *scores: float, chosen: int = 0) -> AgentDecision:
    found = [{"score": score, "terms": [], "x": [0.0, score], "y": [0.0, 1.0]} for score in scores]
    return AgentDecision(tick, 1, 1.0, False, {"chosen": chosen, "candidates": found})


def decisions(*told: AgentDecision, seat: int = 1) -> Decisions:
    return Decisions(told, seat, [START])


def test_decisions_last_until_the_next_one_of_the_same_seat() -> None:
    seen = decisions(decision(5, 0.1), AgentDecision(8, 1, 1.0, False), decision(9, 0.2, 0.3))
    assert [len(seen.at(tick)) for tick in (4, 5, 8, 9, 400)] == [0, 1, 1, 2, 2]
    assert decisions(decision(5, 0.1), seat=0).at(50) == []


def test_candidate_lines_are_coloured_by_score_and_the_chosen_one_is_violet_and_higher() -> None:
    considered = decisions(decision(0, 0.0, 1.0, 0.5, chosen=2)).at(0)
    points, colours = candidate_lines(considered)
    assert points.shape == colours.shape == (3, 2, 3)
    assert (colours[2] == CHOSEN_RGB).all()
    assert points[2, 0, 2] > points[1, 0, 2]
    assert not np.allclose(colours[0], colours[1])


def test_no_candidates_are_no_lines() -> None:
    points, colours = candidate_lines([])
    assert points.shape == colours.shape == (0, 2, 3)


def test_commands_are_drawn_as_the_way_of_a_robot_that_nothing_hinders() -> None:
    ahead, left = (1.0, 1.0, 0.0), (2.0, 0.0, 1.0)  # heading 0 looks along +y; distances are clipped to 1
    detail = {"chosen": 1, "scores": [0.25, 0.5], "candidates": [[ahead, ahead], [left, left]]}
    one, other = candidates(AgentDecision(0, 1, 1.0, False, detail), START)
    start = START.robot_poses[1, :2]
    assert one.path - start == pytest.approx(np.array([[0.0, 0.0], [0.0, 0.06], [0.0, 0.12]]))
    assert other.path - start == pytest.approx(np.array([[0.0, 0.0], [-0.06, 0.0], [-0.12, 0.0]]))
    assert [(found.score, found.chosen) for found in (one, other)] == [(0.25, False), (0.5, True)]


def test_items_that_the_chosen_candidate_moves_get_a_line_to_where_they_end() -> None:
    ends = START.item_poses[:, :2].copy()
    ends[2] += (0.3, 0.0)
    ends[3] += (0.01, 0.0)
    detail = {"chosen": 0, "scores": [1.0], "candidates": [[(1.0, 1.0, 0.0)]], "items": [ends.tolist()]}
    (found,) = candidates(AgentDecision(0, 0, 1.0, False, detail), START)
    assert found.moves == pytest.approx(np.array([[START.item_poses[2, :2], ends[2]]]))
    points, _ = candidate_lines([found])
    assert points.shape == (2, 2, 3)  # one step of its own way, one item


def test_the_robots_are_seen_from_where_they_are_to_where_the_agent_expects_them_for_each_guess() -> None:
    now = START.robot_poses[:, :2]
    ends = np.array([now + shift for shift in (0.1, 0.2, 0.3, 0.4)])[:, None]  # (4 rollouts, 1 moment, 2, 2)
    detail = {
        "chosen": 1,
        "scores": [0.25, 0.5],
        "candidates": [[(1.0, 1.0, 0.0)]] * 2,
        "guesses": [[(1.0, 1.0, 0.0)] * 2, [(0.0, 1.0, 0.0)] * 2],
        "pairs": [[0, 0], [0, 1], [1, 0], [1, 1]],
        "robots": ends.tolist(),
    }
    decision = AgentDecision(0, 1, 1.0, False, detail)
    _, chosen = candidates(decision, START)
    assert chosen.robots == pytest.approx(np.array([[now, now + 0.3], [now, now + 0.4]]))
    points, colours = candidate_lines([chosen])
    assert colours[1:, 0] == pytest.approx(np.array([*SEAT_RGB] * 2))  # blue and red per guess
    assert points[1:, :, :2] == pytest.approx(np.array([[start, start + way] for way in (0.3, 0.4) for start in now]))
    blues_ways = guesses(decision, START) - now[0]
    assert blues_ways == pytest.approx(np.array([[[0.0, 0.0], [0.0, 0.06], [0.0, 0.12]], np.zeros((3, 2))]))


@pytest.mark.parametrize(
    "told", [{}, {"robots": "near"}, {"robots": [[[[0.0, 0.0]] * 2]], "pairs": [[0]]}, {"guesses": [1.0]}]
)
def test_a_recording_without_predicted_robots_still_shows_its_candidates(told: dict[str, object]) -> None:
    decision = AgentDecision(0, 0, 1.0, False, {"scores": [1.0], "candidates": [[(1.0, 1.0, 0.0)]], **told})
    (found,) = candidates(decision, START)
    assert len(found.robots) == len(guesses(decision, START)) == 0


@pytest.mark.parametrize(
    "detail",
    [
        {},
        {"candidates": "fetch"},
        {"candidates": 7},
        {"candidates": [{"plan": "fetch"}]},
        {"candidates": [{"score": 1.0, "x": [0.0, 1.0], "y": [0.0]}]},
        {"candidates": [{"score": 1.0, "x": [], "y": []}]},
        {"candidates": [{"score": None, "x": [0.0], "y": [0.0]}]},
        {"candidates": [[(1.0, 1.0, 0.0)]]},
        {"candidates": [[(1.0, 1.0, math.nan)]], "scores": [1.0]},
        {"candidates": [[(1.0, 1.0)]], "scores": [1.0]},
        {"candidates": [[(1.0, 1.0, 0.0)], []], "scores": [1.0, 2.0]},
    ],
)
def test_what_an_agent_tells_in_its_own_way_is_not_drawn_and_breaks_nothing(detail: dict[str, object]) -> None:
    assert candidates(AgentDecision(0, 0, 1.0, False, detail), START) == []


def test_the_newest_candidates_are_drawn_with_their_scores(tmp_path: Path) -> None:
    with panel(recorded(tmp_path)) as (opened, _):
        put(opened.tick, 4)
        (label,) = opened.scenes[0].labels
        assert (label.text, label.visible) == ("0.50 chosen", True)
        assert tuple(label.position[:2]) == (0.1, 1.1)  # the end of the recorded path
        assert "| 1 | 0.500 | chosen |" in opened.scores.content
        put(opened.candidates, False)
        assert not label.visible
