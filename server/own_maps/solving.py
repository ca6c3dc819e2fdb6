"""Work on a map that takes a while: checking, varying and making it, and playing a scripted pair on it.

Called in a worker process.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from movingout.agents.catalogue import load_agent
from movingout.agents.data.rollout import rollout
from movingout.maps import MapSpec, load_map, map_from_json
from movingout.maps.check import MapFault, check_map
from movingout.maps.commands.map_cautions import hints_on
from movingout.maps.document_check import check_document, fault_of
from movingout.maps.errors import MapDocumentError, MapError
from movingout.maps.official import is_official, map_from_official
from movingout.maps.randomize import Split, randomize
from movingout.matches.execution.decision_timeout import DecisionTimeout, DecisionTimer
from movingout.server.own_maps.folder import Outcome, read_map_file
from movingout.world import World
from movingout.world.constants import LIMIT_TICKS
from movingout.world.scoring import delivered_items
from movingout.world.state import WorldState

CHECK_S = 5.0
SOLVE_S = 20.0
VARIANT_S = 10.0  # of a visitor; one of a shipped map takes a third of a second
OWN_VARIANT_S = 60.0  # of a study, or of the operator: their maps may be tight
_DECIMALS = 4


class Checked(NamedTuple):
    """The map of a document, None where it cannot be read; what keeps it from being played, and hints."""

    map: MapSpec | None
    faults: tuple[MapFault, ...]
    hints: tuple[MapFault, ...] = ()


class TooSlow(MapError):
    """The work was broken off after its time."""


def check(document: object) -> Checked:
    """The map of a JSON document, in our format or the official one, its faults and hints. Raises TooSlow."""
    with _time_limit(CHECK_S):
        try:
            official = isinstance(document, dict) and is_official(document)
            spec = map_from_official(document, "Map") if official else map_from_json(document)  # type: ignore[arg-type]
        except MapDocumentError as error:
            return Checked(None, (fault_of(error),) if official else check_document(document))
        except MapError as error:
            return Checked(None, (MapFault("the map", str(error), "official"),))
        return Checked(spec, check_map(spec), hints_on(spec))


def generate(name: str) -> MapSpec:
    """The generated map of a name. Raises TooSlow, and MapError for a name of none."""
    with _time_limit(CHECK_S):
        return load_map(name)


def variant(designed: MapSpec, seed: int, split: Split, within_s: float) -> MapSpec:
    """`randomize` within a time limit. Raises TooSlow, and MapError where there is no variant."""
    with _time_limit(within_s):
        return randomize(designed, seed, split)


def read_file(path: Path) -> Outcome:
    """`read_map_file` within a time limit."""
    try:
        with _time_limit(CHECK_S):
            return read_map_file(path)
    except TooSlow as error:
        return f"{path.name}: {error}"


def solve(spec: MapSpec) -> dict[str, Any]:
    """What a scripted pair does on a map: how many items it delivers in how many ticks, and a picture of every tick.

    `frames` has one entry per tick from 0: the poses of the two robots and of the items [x, y, angle], what each robot
    holds (the index of an item, -1 for none) and which items are delivered. Raises TooSlow.
    """
    with _time_limit(SOLVE_S):
        states = [World(spec).state()]
        pair = load_agent("scripted"), load_agent("scripted")
        states += [step.after for step in rollout(spec, pair, seed=0, ticks=LIMIT_TICKS)]
        frames = [_frame(spec, state) for state in states]
    done = frames[-1]["delivered"]
    return {
        "solved": all(done),
        "ticks": len(frames) - 1,
        "limit_ticks": LIMIT_TICKS,
        "delivered": sum(done),
        "items": len(done),
        "frames": frames,
    }


def _frame(spec: MapSpec, state: WorldState) -> dict[str, Any]:
    poses = np.round(np.concatenate([state.robot_poses, state.item_poses]), _DECIMALS).tolist()
    return {"poses": poses, "held": state.held.tolist(), "delivered": delivered_items(spec, state.item_poses).tolist()}


@contextmanager
def _time_limit(seconds: float) -> Iterator[None]:
    """Raises TooSlow in this block after a while. It needs the main thread, in which worker processes work."""
    timer = DecisionTimer(seconds)
    try:
        with timer.running():
            timer.start()
            yield
    except DecisionTimeout:
        raise TooSlow(f"this took longer than {seconds:g} s and was stopped") from None
