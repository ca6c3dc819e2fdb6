"""The paper's sentence about Overcooked-AI: by how much BASS changes the score of its Diffusion Policy there."""

import contextlib
import io
import math
from dataclasses import dataclass
from typing import NamedTuple

from movingout.agents.overcooked.kitchen import MISSING, is_installed
from movingout.matches.paper.cells import EmptyCell, Found, MeasuredCell, Measurement, PaperCell
from movingout.matches.paper.pooling import between, fields, pooled
from movingout.matches.paper.training import training_seed
from movingout.matches.paper.workspace import DATA, Measured, Workspace
from movingout.world.estimates import Estimate, estimate

TICKS = 400  # of a game, as in the package's own benchmarks


class _Sizes(NamedTuple):
    """A budget of its own: one room is soon learned, but not with a thousand updates."""

    updates: int  # of the Diffusion Policy
    simulator_updates: int
    width: int
    batch: int
    games: int  # of each agent and training
    minutes: float  # on one core, measured but for `full`


_SIZES = {
    "smoke": _Sizes(3, 3, 16, 16, 2, 0.5),
    "small": _Sizes(8000, 3000, 256, 256, 60, 15.0),
    "paper-size": _Sizes(8000, 3000, 256, 256, 60, 15.0),
    "full": _Sizes(20_000, 20_000, 256, 1024, 400, 200.0),
}


@dataclass(frozen=True, slots=True)
class _ChangeCell(MeasuredCell):
    """By how much the mean score over all trainings changes; no value where the policy alone made no point."""

    def found(self, space: Workspace) -> Found | None:
        measured = self.measurement.of_all(space)
        if measured is None:
            return None
        before, after = (pooled(fields(measured, name)) for name in ("dp_score", "bass_score"))
        each = [relative_change(one["dp_score"], one["bass_score"]) for one in measured]
        return Found(relative_change(before, after), between=between(each))


def overcooked_change() -> PaperCell:
    """The relative change; empty without the package."""
    return _ChangeCell(_MEASUREMENT, "change") if is_installed() else EmptyCell(MISSING)


def relative_change(before: Estimate, after: Estimate) -> Estimate | None:
    """after / before - 1 with its standard error by error propagation; None where `before` is 0."""
    if before.mean <= 0.0 or before.stderr is None or after.stderr is None:
        return None
    ratio = after.mean / before.mean
    error = math.hypot(after.stderr / before.mean, ratio * before.stderr / before.mean)
    return Estimate(ratio - 1.0, error, before.n + after.n)


def _measure(space: Workspace, training: int) -> Measured:
    """The scores of one training."""
    from movingout.agents.overcooked.play import play_kitchen
    from movingout.agents.overcooked.recordings import kitchen_episodes
    from movingout.agents.overcooked.training import KitchenSizes, train_kitchen

    said = _SIZES[space.budget.name]
    sizes = KitchenSizes(
        updates=said.updates, simulator_updates=said.simulator_updates, width=said.width, batch=said.batch
    )
    with contextlib.redirect_stderr(io.StringIO()), contextlib.redirect_stdout(io.StringIO()):
        seed, folder = training_seed(training, space), DATA / "runs" / f"overcooked-{training}"
        parts = train_kitchen(kitchen_episodes(), sizes, seed, folder)
    games = {name: play_kitchen(parts, said.games, TICKS, space.seed, bass=name == "bass") for name in ("dp", "bass")}
    return {f"{name}_score": value for name, points in games.items() if (value := estimate(points))}


_MEASUREMENT = Measurement(
    name="overcooked",
    about="BASS and its Diffusion Policy in Overcooked-AI, trained on what people played there",
    perform=_measure,
    seconds=lambda budget: 60.0 * _SIZES[budget.name].minutes,
    repeated=True,
)
