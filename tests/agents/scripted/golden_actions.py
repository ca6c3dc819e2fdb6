"""Golden actions of two scripted agents: `python -m tests.agents.scripted.golden_actions` makes them anew.

Needed only when the scripted agent is to plan differently. The agents are asked about recorded states, so that a
difference in one tick does not hide behind those that follow from it.
"""

import json
from pathlib import Path

import numpy as np
import numpy.typing as npt

from movingout.agents.action_chunk import world_action
from movingout.agents.base import EpisodeInfo
from movingout.agents.catalogue import load_agent
from movingout.agents.observation.seat_observation import observe
from movingout.maps import load_map
from movingout.recordings.versions import versions
from movingout.world import World

FILE = Path(__file__).parent / "golden_actions.npz"
MAPS = ("HandOff", "SingleRotation", "AdaptiveAssist", "DistancePriority")
TICKS = 120

Rows = npt.NDArray[np.float64]


def replayed(map_name: str, recorded: Rows | None = None) -> Rows:
    """(T, 2, 4) what both agents answer to the states that the `recorded` rows lead to, else to those of their own."""
    spec = load_map(map_name)
    world, agents = World(spec, record_sub_poses=False), [load_agent("scripted") for _ in range(2)]
    for seat, agent in enumerate(agents):
        agent.reset(EpisodeInfo(spec, seat, seed=seat, ticks=500))
    rows = []
    for tick in range(TICKS if recorded is None else len(recorded)):
        state = world.state()
        rows.append(np.array([agent.act(observe(spec, state, seat))[0] for seat, agent in enumerate(agents)]))
        played = rows[-1] if recorded is None else recorded[tick]
        world.step(np.array([world_action(row) for row in played]))
        if world.delivered().all():
            break
    return np.array(rows)


def main() -> None:
    """Write the file."""
    made = {name: replayed(name) for name in MAPS}
    np.savez_compressed(FILE, versions=np.array(json.dumps(versions())), **made)  # type: ignore[arg-type]


if __name__ == "__main__":
    main()
