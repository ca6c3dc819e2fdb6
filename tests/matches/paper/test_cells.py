"""A number in a cell stands for all trainings, with the error between them."""

from dataclasses import replace
from pathlib import Path

import pytest

from movingout.matches.match import Match, MatchResult
from movingout.matches.paper import workspace
from movingout.matches.paper.budgets import BUDGETS
from movingout.matches.paper.cells import MeasuredCell, Measurement, Play, PlayedCell
from movingout.matches.paper.methods import trained_id
from movingout.matches.paper.other_games.overcooked import overcooked_row
from movingout.matches.paper.presentation.layout import _change, laid_out, number_text
from movingout.matches.paper.published import PublishedColumn
from movingout.matches.paper.registry import ENTRIES
from movingout.matches.paper.steps import paper_steps
from movingout.matches.paper.workspace import Workspace
from movingout.world.estimates import Estimate
from movingout.world.metrics import Metrics

TWICE = replace(BUDGETS["smoke"], trainings=2, seeds=3)


class _Played(Workspace):
    """A workspace in which every match has been played; later trainings deliver more."""

    def result(self, match: Match) -> MatchResult | None:
        training = trained_id(match.blue).seed
        metrics = Metrics.of({"tcr": 0.2 + 0.2 * training, "nfd": 0.5, "wt_s": 1.5, "ac": None})
        played = MatchResult(match, "time", 60, 0, 4, metrics, 0.03)
        return replace(played, play_hash=f"{match.map} {match.blue}")


def test_a_played_cell_has_the_error_between_trainings_and_counts_copies_once() -> None:
    cell = PlayedCell((Play("mlp@c1"),), 1, "tcr", ("HandOff", "LeftRight"))
    space = _Played(budget=TWICE)
    assert [match.blue for match in cell.matches(space)] == ["mlp@c1"] * 6 + ["mlp@c1-1"] * 6
    found = cell.found(space)
    assert found is not None and found.estimate is not None and found.between is not None
    assert found.estimate.mean == pytest.approx(0.3) and found.estimate.n == 12 and found.distinct == 4
    assert found.estimate.stderr == pytest.approx(0.1 * (4 / 3) ** 0.5 / 2)
    assert found.between == pytest.approx(Estimate(0.3, 0.1, 2))
    assert number_text(found) == "0.3000 ± 0.0577 (trainings ± 0.1000)"
    assert number_text(cell.found(_Played(budget=replace(TWICE, trainings=1)))) == "0.2000 ± 0.0000"
    notes = laid_out(ENTRIES["tab:nfd_vs_ac"], space).notes
    assert any("standard error between the means of the trainings, n = 2" in note for note in notes)


def test_what_is_measured_of_agents_is_measured_of_every_training(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    space = Workspace(budget=TWICE)
    steps = [step.about for step in paper_steps([ENTRIES["tab:next_state_pred"]], space)]
    about = "measure accuracy of bass@a on episodes of pairs in turn that it has not learned from"
    assert about in steps and f"{about}, training 2" in steps and "train bass@a-1 (bass)" in steps
    timed = [step.about for step in paper_steps([ENTRIES["text:inference_time"]], space)]
    assert not any("training 2" in about or "-1 (" in about for about in timed), "time is measured once"
    one = Measurement("one", "", lambda space, training: {}, agents=("bass@a",), repeated=True)
    cell = MeasuredCell(one, "l2")
    space.keep("one", {"l2": Estimate(0.2, 0.1, 10)}, one.agents_of(0))
    assert cell.found(space) is None
    space.keep("one-1", {"l2": Estimate(0.4, 0.1, 10)}, one.agents_of(1))
    found = cell.found(space)
    assert found is not None and found.estimate is not None and found.between is not None
    assert found.estimate.mean == pytest.approx(0.3) and found.estimate.n == 20 and found.between.n == 2
    first = replace(cell, of_first=True).found(space)
    assert first is not None and first.estimate == Estimate(0.2, 0.1, 10) and first.between is None
    random = [cell.ours for cell in ENTRIES["tab:next_state_pred"].cells() if cell.row.name == "Random States"]
    assert all(isinstance(one, MeasuredCell) and one.of_first for one in random)


def test_a_measurement_of_other_weights_is_made_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    weights = {"bass@a": "first"}
    monkeypatch.setattr(workspace, "fingerprint", lambda agent_id: weights.get(agent_id, ""))
    space = Workspace(budget=TWICE)
    space.keep("one", {"l2": Estimate(0.2, 0.1, 10)}, ("bass@a",))
    assert space.measured("one", ("bass@a",)) == {"l2": Estimate(0.2, 0.1, 10)}
    weights["bass@a"] = "again"
    assert space.measured("one", ("bass@a",)) is None
    (tmp_path / "data" / "measured" / "old.json").write_text('{"l2": [0.2, 0.1, 10]}', encoding="utf-8")
    assert space.measured("old", ("bass@a",)) == {"l2": Estimate(0.2, 0.1, 10)}, "of an earlier version"


def test_overcooked_changes_by_the_mean_over_trainings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("movingout.matches.paper.other_games.overcooked.is_installed", lambda: True)
    cell = overcooked_row("bass")(PublishedColumn(0, "change"))
    space = Workspace(budget=TWICE)
    space.keep("overcooked", {"dp_score": Estimate(50.0, 3.0, 20), "bass_score": Estimate(90.0, 3.0, 20)})
    for training, before, after in ((0, 50.0, 60.0), (1, 100.0, 105.0)):
        assert cell.found(space) is None, "of a training that is missing, or of before"
        scores = {"dp_score": Estimate(before, 3.0, 20), "bass_score": Estimate(after, 3.0, 20)}
        space.keep("overcooked-ablation" + f"-{training}" * training, scores)
    found = cell.found(space)
    assert found is not None and found.estimate is not None and found.between is not None
    assert found.estimate.mean == pytest.approx(0.1) and found.estimate.n == 80
    assert found.between.mean == pytest.approx((0.2 + 0.05) / 2) and found.between.n == 2


@pytest.mark.parametrize(
    ("before", "now", "text"),
    [(0.5, 0.25, " (-50.00 %)"), (0.5, None, ""), (None, 0.5, ""), (0.0, 0.5, ""), (-0.0004, 0.004, "")],
)
def test_a_change_is_a_share_of_what_is_above_nothing(before: float | None, now: float | None, text: str) -> None:
    assert _change(before, now) == text
