"""How much is recorded, trained and played for a table. Only `full` has the paper's sizes throughout."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from movingout.maps.suggestion import known_names
from movingout.matches.errors import MatchError
from movingout.world.constants import LIMIT_TICKS


@dataclass(frozen=True, kw_only=True)
class Budget:
    """The sizes of everything that a table needs."""

    name: str
    about: str
    gpu: bool = False  # whether its times are those of the paper's GPU
    preset: str  # of `movingout train`
    people: int  # scripted people of each population who record, where no recordings are given
    episodes: int  # that each pair records per map, for Challenge 1
    variants: int  # episodes per map for Challenge 2, each on a variant of its own
    ticks: int = LIMIT_TICKS  # limit of an episode and of a match
    trainings: int = 1  # of each agent, with seeds 0, 1, …
    seeds: int  # matches per pair and map
    moments: int  # per episode, at which predictions are compared with what happened
    states: int  # that are perturbed, per level of noise: five times as many, up to 2,000
    options: Mapping[str, tuple[Any, ...]] = field(default_factory=dict)  # of `movingout train`, by kind

    @property
    def sentence(self) -> str:
        """Its name and what it is for, below a table or figure."""
        return f"Budget {self.name}: {self.about}."


GROWING = "trainings", "seeds"  # sizes of which a folder may get more later: what it has is used again
_TINY = "--updates", 3, "--batch", 16, "--width", 16, "--evaluate-every", 3
_TINY_PLAY = (
    "--frames", 24, "--frames-per-batch", 24, "--envs", 3, "--passes", 1, "--batch", 24, "--width", 16, "--ticks", 8,
)  # fmt: skip
_SMALL_PLAY = "--frames", 12_000, "--members", 2
_SMALL = "--evaluate-every", 500, "--batch", 128, "--width", 128
_MEDIUM = "--updates", 6000, "--evaluate-every", 1000, "--batch", 256, "--width", 256
_PAPER_SIZE = "--updates", 6000, "--evaluate-every", 1000, "--batch", 256, "--precision", "bf16"
_BUDGETS = (
    Budget(
        name="smoke",
        about="checks in a few minutes that every step runs; the numbers mean nothing",
        preset="fast", people=4, episodes=1, variants=1, ticks=24, seeds=1, moments=1, states=20,
        options={"mlp": _TINY, "gru": _TINY, "dp": _TINY, "bass": (*_TINY, "--latent", 4, "--progress-updates", 3),
                 "mappo": _TINY_PLAY, "comedi": (*_TINY_PLAY, "--members", 2)},
    ),
    Budget(
        name="small",
        about="small networks, short trainings, a match per pair and map; shows the order of methods at best",
        preset="fast", people=4, episodes=2, variants=6, seeds=1, moments=2, states=400,
        options={
            "mlp": ("--updates", 1000, *_SMALL), "gru": ("--updates", 600, *_SMALL),
            "dp": ("--updates", 1000, *_SMALL), "bass": ("--updates", 1000, "--progress-updates", 1000, *_SMALL),
            "mappo": _SMALL_PLAY[:2], "comedi": _SMALL_PLAY,
        },
    ),
    Budget(
        name="medium",
        about="small networks, with episodes and updates enough to deliver; an hour or so for a table, four with MAPPO",
        preset="fast", people=18, episodes=2, variants=30, seeds=3, moments=4, states=400,
        options={
            "mlp": _MEDIUM, "gru": _MEDIUM, "dp": _MEDIUM, "bass": (*_MEDIUM, "--progress-updates", 6000),
            "mappo": ("--frames", 600_000), "comedi": ("--frames", 300_000, "--members", 2),
        },
    ),
    Budget(
        name="paper-size",
        about="the paper's networks, with the episodes of small and 6,000 updates; a night for a table",
        preset="paper", people=4, episodes=2, variants=6, seeds=1, moments=2, states=400,
        options={
            "mlp": _PAPER_SIZE, "gru": _PAPER_SIZE, "dp": _PAPER_SIZE,
            "bass": (*_PAPER_SIZE, "--progress-updates", 6000),
            "mappo": ("--frames", 600_000), "comedi": _SMALL_PLAY,
        },
    ),
    Budget(
        name="full", gpu=True,
        about="the paper's networks, epochs and numbers of episodes, three trainings: for a GPU, or a cluster",
        preset="paper", people=18, episodes=6, variants=60, trainings=3, seeds=20, moments=10, states=2000,
        options={"bass": ("--progress-updates", 8000)},  # the paper gives none; the preset's 800 are a small network's
    ),
)  # fmt: skip
BUDGETS = {budget.name: budget for budget in _BUDGETS}


def budget_of(name: str) -> Budget:
    """Raises MatchError for a name that is none."""
    if name not in BUDGETS:
        raise MatchError(f"there is no budget {name!r}; {known_names(name, BUDGETS)}")
    return BUDGETS[name]
