"""The package `overcooked-ai` behind our interfaces: its states as vectors, its six actions as our five numbers.

A cook's action is distance 1 and a heading of right, left, down or up; distance 0; or a press, which is `interact`. So
policies, denoisers, chunks and pairs of chunks are those of Moving Out.

Rules are those that people played by in 2019: a pot with three onions cooks by itself, one with fewer does not cook.
The package (1.1.0) has later rules, by which a cook starts the pot, and takes no notice of its option `old_dynamics`.
"""

import contextlib
import importlib.util
import io
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from movingout.agents.errors import AgentError
from movingout.maps.extras import install_command

Singles = npt.NDArray[np.float32]

LAYOUT = "cramped_room"
WIDTH, HEIGHT = 5, 4  # tiles of the room
HEADINGS = ((1, 0), (-1, 0), (0, 1), (0, -1))
STAY, INTERACT = (0, 0), "interact"
CARRIED = ("onion", "dish", "soup")
COOKING_TICKS = 20
_TILES = WIDTH * HEIGHT
_COOK = _TILES + len(HEADINGS) + len(CARRIED)
KITCHEN_SIZE = 2 * _COOK + _TILES * len(CARRIED) + 6
"""Numbers of an observation: own cook, other cook, what lies on each tile, the pot."""
MISSING = f"Overcooked-AI is not installed; install it with: {install_command('overcooked')}"


def is_installed() -> bool:
    """Whether the package can be imported."""
    return importlib.util.find_spec("overcooked_ai_py") is not None


class Kitchen:
    """One room of the package. Raises AgentError where the package is missing."""

    def __init__(self) -> None:
        if not is_installed():
            raise AgentError(MISSING)
        with warnings.catch_warnings(), contextlib.redirect_stderr(io.StringIO()):
            warnings.simplefilter("ignore")  # it imports `gym`, which prints that it is no longer maintained
            from overcooked_ai_py.mdp.overcooked_mdp import OvercookedGridworld
        with contextlib.redirect_stdout(io.StringIO()):
            self._rules: Any = OvercookedGridworld.from_layout_name(LAYOUT)
        self._rules.soup_to_be_cooked_at_location = _no_cook_starts_a_pot
        self.state: Any = self._rules.get_standard_start_state()
        """Of the package. May be set to a state kept earlier: a step makes a new one and leaves it as it is."""

    @property
    def tiles(self) -> list[tuple[int, int]]:
        """Where a cook can stand."""
        return list(self._rules.get_valid_player_positions())

    def step(self, rows: Singles) -> float:
        """Play a tick of both cooks' rows (2, 5) and return the points made in it, 20 per soup."""
        self.state, told = self._rules.get_state_transition(self.state, [action_of(row) for row in rows])
        for thing in self.state.objects.values():
            if thing.name == "soup" and thing.is_idle and thing.is_full:
                thing.begin_cooking()
                thing.cook()  # as in 2019: the tick of the third onion counts
        return float(sum(told["sparse_reward_by_agent"]))

    def observation(self, cook: int) -> Singles:
        """What a cook sees (120,)."""
        return features(self.state.to_dict(), cook)


def _no_cook_starts_a_pot(state: Any, position: tuple[int, int]) -> bool:
    return False


def recordings_folder() -> Path:
    """Where the package keeps its recordings of people. Raises AgentError where it is missing."""
    found = importlib.util.find_spec("overcooked_ai_py")
    if found is None or not found.submodule_search_locations:
        raise AgentError(MISSING)
    return Path(found.submodule_search_locations[0]) / "data" / "human_data"


def features(state: Mapping[str, Any], cook: int) -> Singles:
    """A state as written by the package, today or in 2019, as the vector (120,) that a cook sees."""
    cooks = [_cook(state["players"][index]) for index in (cook, 1 - cook)]
    objects = state["objects"]
    lying, pot = np.zeros((_TILES, len(CARRIED)), np.float32), np.zeros(6, np.float32)
    for one in objects.values() if isinstance(objects, Mapping) else objects:
        onions, ticks = _soup(one)
        if one["name"] == "soup" and ticks is not None:
            pot[min(onions, 3)] = 1.0
            pot[4:] = min(max(ticks, 0) / COOKING_TICKS, 1.0), float(ticks >= COOKING_TICKS)
        lying[tile_of(one["position"]), CARRIED.index(one["name"])] = 1.0
    if not pot[:4].any():
        pot[0] = 1.0
    return np.concatenate((*cooks, lying.ravel(), pot))


def _cook(player: Mapping[str, Any]) -> Singles:
    row = np.zeros(_COOK, np.float32)
    row[tile_of(player["position"])] = 1.0
    if tuple(player["orientation"]) in HEADINGS:
        row[_TILES + HEADINGS.index(tuple(player["orientation"]))] = 1.0
    if held := player.get("held_object"):
        row[_TILES + len(HEADINGS) + CARRIED.index(held["name"])] = 1.0
    return row


def _soup(thing: Mapping[str, Any]) -> tuple[int, int | None]:
    """Onions in a soup and how long it has been cooking; None for what is no soup."""
    if thing["name"] != "soup":
        return 0, None
    if "state" in thing:  # as of 2019: what of, how many, how long
        return int(thing["state"][1]), int(thing["state"][2])
    return len(thing["_ingredients"]), int(thing["_cooking_tick"])


def tile_of(position: tuple[int, int]) -> int:
    """The number of a tile, row by row."""
    x, y = position
    return WIDTH * int(y) + int(x)


def action_of(row: Singles) -> tuple[int, int] | str:
    """The action that a row (5,) means."""
    if row[4] > row[3]:
        return INTERACT
    if row[0] < 0.5:
        return STAY
    return max(HEADINGS, key=lambda heading: float(row[1] * heading[0] + row[2] * heading[1]))


def row_of(action: Any, facing: Any) -> Singles:
    """A recorded action as a row (5,); a cook who stays or interacts keeps its heading."""
    press = isinstance(action, str)
    moves = not press and tuple(action) in HEADINGS
    x, y = action if moves else facing
    return np.array([moves, x, y, -1.0 if press else 1.0, 1.0 if press else -1.0], dtype=np.float32)
