"""The paper's sentence about Overcooked-AI: what BASS and each of its parts change in the score of the policy there."""

import contextlib
import io
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from movingout.agents.overcooked.kitchen import MISSING, is_installed
from movingout.matches.paper.cells import EmptyCell, Found, MeasuredCell, Measurement, PaperCell
from movingout.matches.paper.entry import RowCells
from movingout.matches.paper.pooling import between, fields, pooled
from movingout.matches.paper.published import PublishedColumn
from movingout.matches.paper.training import training_seed
from movingout.matches.paper.workspace import DATA, Measured, Workspace
from movingout.world.estimates import Estimate, estimate

TICKS = 400  # of a game, as in the package's own benchmarks
DP, AUGMENTED, SELECTED, BASS = "dp", "augmented", "selected", "bass"
ROWS = {"DP": DP, "DP + BASS w/o Simulation": AUGMENTED, "DP + BASS w/o Augmentation": SELECTED, "DP + BASS": BASS}
"""As the paper names them in its own ablation."""


class _Sizes(NamedTuple):
    """A budget of its own: one room is soon learned, but not with a thousand updates."""

    updates: int  # of the Diffusion Policy
    simulator_updates: int
    width: int
    batch: int
    games: int  # of each agent and training
    minutes: float  # on one core for each training, measured for `smoke` and `small`


_SMALL = _Sizes(8000, 3000, 256, 256, 60, 16.0)
_SIZES = {
    "smoke": _Sizes(3, 3, 16, 16, 2, 0.6),
    "small": _SMALL,
    "medium": _SMALL._replace(updates=20_000, simulator_updates=6000, games=120, minutes=40.0),
    "paper-size": _SMALL,
    "full": _Sizes(20_000, 20_000, 256, 1024, 400, 300.0),
}


@dataclass(frozen=True, slots=True)
class _ChangeCell(MeasuredCell):
    """By how much the mean score over all trainings changes; no value where the policy alone made no point."""

    def found(self, space: Workspace) -> Found | None:
        measured = self.measurement.of_all(space)
        if measured is None:
            return None
        before, after = (pooled(fields(measured, f"{who}_score")) for who in (DP, self.field))
        each = [relative_change(one[f"{DP}_score"], one[f"{self.field}_score"]) for one in measured]
        return Found(relative_change(before, after), between=between(each))


def overcooked_row(who: str) -> RowCells:
    """What is shown of one of `ROWS`; empty without the package."""
    compared = {"change": _ChangeCell(_MEASUREMENT, who), "score_gain": MeasuredCell(_MEASUREMENT, f"{who}_gain")}

    def cell(column: PublishedColumn) -> PaperCell:
        if not is_installed():
            return EmptyCell(MISSING)
        if column.measure == "valid_share":
            return _VALID if who in (AUGMENTED, BASS) else EmptyCell("nothing is recombined")
        if column.measure == "score":
            return MeasuredCell(_MEASUREMENT, f"{who}_score")
        return EmptyCell("what the others are compared with") if who == DP else compared[column.measure]

    return cell


def relative_change(before: Estimate, after: Estimate) -> Estimate | None:
    """after / before - 1 with its standard error by error propagation; None where `before` is 0."""
    if before.mean <= 0.0 or before.stderr is None or after.stderr is None:
        return None
    ratio = after.mean / before.mean
    error = math.hypot(after.stderr / before.mean, ratio * before.stderr / before.mean)
    return Estimate(ratio - 1.0, error, before.n + after.n)


def _measure(space: Workspace, training: int) -> Measured:
    """The scores of one training; both policies have the same simulator, and all start with the same noise."""
    from movingout.agents.overcooked.augmentation import augmented_samples
    from movingout.agents.overcooked.play import play_kitchen
    from movingout.agents.overcooked.recordings import kitchen_episodes, kitchen_windows
    from movingout.agents.overcooked.training import KitchenSizes, train_cook, train_kitchen

    said = _SIZES[space.budget.name]
    sizes = KitchenSizes(
        updates=said.updates, simulator_updates=said.simulator_updates, width=said.width, batch=said.batch
    )
    with contextlib.redirect_stderr(io.StringIO()), contextlib.redirect_stdout(io.StringIO()):
        seed, folder = training_seed(training, space), DATA / "runs" / f"overcooked-{training}"
        episodes = kitchen_episodes()
        plain = train_kitchen(episodes, sizes, seed, folder)
        samples, report = augmented_samples(episodes, seed)
        policy = train_cook(kitchen_windows(episodes, samples), sizes, seed, folder / "augmented")
    learned = replace(plain, policy=policy)
    points = {
        who: play_kitchen(learned if who in (AUGMENTED, BASS) else plain, said.games, TICKS, space.seed, bass=selects)
        for who, selects in ((DP, False), (AUGMENTED, False), (SELECTED, True), (BASS, True))
    }
    error = math.sqrt(report.share * (1.0 - report.share) / report.tried)
    return {**scores(points), "valid_share": Estimate(report.share, error, report.tried)}


def scores(points: Mapping[str, list[float]]) -> Measured:
    """Mean points of a game (`dp_score`), and above those of DP in the game with the same number (`bass_gain`)."""
    gains = {f"{who}_gain": np.subtract(found, points[DP]).tolist() for who, found in points.items() if who != DP}
    values = {**{f"{who}_score": found for who, found in points.items()}, **gains}
    return {name: one for name, found in values.items() if (one := estimate(found))}


_MEASUREMENT = Measurement(
    name="overcooked-ablation",  # without it, `overcooked` of earlier folders had no augmentation
    about="BASS, its parts and its Diffusion Policy in Overcooked-AI, trained on what people played there",
    perform=_measure,
    seconds=lambda budget: 60.0 * _SIZES[budget.name].minutes,
    repeated=True,
)
_VALID = MeasuredCell(_MEASUREMENT, "valid_share")
