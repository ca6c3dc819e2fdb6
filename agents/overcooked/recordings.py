"""What people played in "Cramped Room" in 2019, as it comes with the package: sixteen pairs, two minutes each and more.

The files are pickles: they are read from the installed package alone, whose code runs anyway, and from nowhere else.
"""

import ast
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from movingout.agents.data.dataset import SeatSamples, Windows, windows_of
from movingout.agents.errors import AgentError
from movingout.agents.overcooked.kitchen import LAYOUT, Singles, features, recordings_folder, row_of

PARTS = ("train", "test")


@dataclass(frozen=True, slots=True, eq=False)
class KitchenEpisode:
    """A game of a pair."""

    pair: str
    observations: Singles  # (T, 2, 120) of both cooks
    rows: Singles  # (T, 2, 5) what both did
    soups: Singles  # (T,) delivered in each tick

    def participant(self, cook: int) -> str:
        """Who a cook is."""
        return f"{self.pair}, cook {cook}"


def kitchen_episodes(ticks: int | None = None) -> list[KitchenEpisode]:
    """The games of all pairs, or their first ticks. Raises AgentError where package or pandas are missing."""
    try:
        import pandas
    except ImportError as error:
        raise AgentError("reading what people played needs pandas; install the extra overcooked") from error
    found = []
    for part in PARTS:
        table = pandas.read_pickle(recordings_folder() / f"clean_{part}_trials.pickle")
        table = table[table.layout_name == LAYOUT].sort_values(["workerid_num", "cur_gameloop"])
        for number, game in table.groupby("workerid_num"):
            found.append(_episode(f"pair {number}", game if ticks is None else game.head(ticks)))
    return found


def _episode(pair: str, game: Any) -> KitchenEpisode:
    states = [_plain(text) for text in game.state]
    actions = [_plain(text) for text in game.joint_action]
    seen = [[features(state, cook) for cook in (0, 1)] for state in states]
    done = [
        [row_of(each[cook], state["players"][cook]["orientation"]) for cook in (0, 1)]
        for state, each in zip(states, actions, strict=True)
    ]
    return KitchenEpisode(
        pair, np.array(seen, np.float32), np.array(done, np.float32), (game.reward.to_numpy() > 0).astype(np.float32)
    )


def _plain(text: str) -> Any:
    """A written Python value of plain numbers, texts, lists and mappings."""
    return ast.literal_eval(text)


def kitchen_windows(episodes: Sequence[KitchenEpisode], more: Sequence[SeatSamples] = ()) -> Windows:
    """Training windows of both cooks, and of more samples."""
    recorded = [
        SeatSamples(one.participant(cook), one.observations[:, cook], one.rows[:, cook])
        for one in episodes
        for cook in (0, 1)
    ]
    return windows_of([*recorded, *more])
