"""Cells of agents that learned by reinforcement: one agent per map, as the paper's MAPPO, and how they behave.

What the paper says of behaviour ("Comparative analysis of the Behaviors of BC and RL agents") it says in words: MAPPO
goes for a middle-sized item first where people also take the small ones (map 6), and its first movements look
exploratory until one robot commits to a large item (map 11). Here both are counted in episodes of an agent with itself.
"""

from collections.abc import Iterator
from functools import partial

import numpy as np

from movingout.agents.catalogue import load_agent
from movingout.agents.data.rollout import RolloutStep, rollout
from movingout.maps import load_map, map_names
from movingout.matches.paper.budgets import Budget
from movingout.matches.paper.cells import MeasuredCell, Measurement, PaperCell, Play, PlayedCell, PooledCell
from movingout.matches.paper.entry import RowCells
from movingout.matches.paper.methods import with_seed
from movingout.matches.paper.pooling import averaged
from movingout.matches.paper.published import PublishedColumn
from movingout.matches.paper.rows.diversity import diversity_over_maps, equal_sizes
from movingout.matches.paper.workspace import Measured, Workspace
from movingout.world.constants import LIMIT_TICKS, TICKS_PER_SECOND
from movingout.world.estimates import estimate
from movingout.world.state import Floats

EPISODES = 4  # of each of the two agents, or as many as the budget has matches where those are more
BEHAVIOUR = "map_6_middle_first", "map_6_first_grasp_s", "map_11_first_grasp_s", "map_11_first_shared_s"


def reinforced_seen(column: PublishedColumn) -> PaperCell:
    """MAPPO on each map with itself, both trainings."""
    return PooledCell(tuple(_alone("mappo", number, column.measure) for number in range(1, len(map_names()) + 1)))


def reinforced_unseen(column: PublishedColumn) -> PaperCell:
    """One training of MAPPO with the other, on each map."""
    numbers = range(1, len(map_names()) + 1)
    return PooledCell(
        tuple(
            PlayedCell((Play(f"mappo-{k}@a", f"mappo-{k}@b"),), 1, column.measure, (map_names()[k - 1],))
            for k in numbers
        )
    )


def reinforced_varied(column: PublishedColumn) -> PaperCell:
    """MAPPO on each map with itself, trained on another Challenge 2 variant in every episode; not in the paper."""
    names = enumerate(map_names(), start=1)
    return PooledCell(
        tuple(PlayedCell((Play(f"mappo-{number}@c2"),), 2, column.measure, (name,)) for number, name in names)
    )


def zero_shot(kind: str) -> RowCells:
    """tcr_map_12_unseen: on map 12 with partners that learned from the episodes of people (DP of group b)."""

    def cell(column: PublishedColumn) -> PaperCell:
        _, _, number, who = column.measure.split("_")
        if who == "seen":
            return _alone(kind, int(number), "tcr")
        plays = tuple(Play(f"{kind}-{number}@{seed}", "dp@b") for seed in "ab")
        return PlayedCell(plays, 1, "tcr", (map_names()[int(number) - 1],))

    return cell


def behaviour(method: str) -> RowCells:
    """How an agent behaves on maps 6 and 11, and what it reaches there; `{}` in its method is the map's number."""

    def cell(column: PublishedColumn) -> PaperCell:
        if column.measure in BEHAVIOUR:
            number = column.measure.split("_")[1]
            return _behaviour(method.format(number), int(number), column.measure)
        measure, _, number = column.measure.split("_")  # tcr_map_6
        plays = tuple(Play(f"{method.format(number)}@{seed}") for seed in "ab")
        return PlayedCell(plays, 1, measure, (map_names()[int(number) - 1],))

    return cell


def played_diversity(field: str) -> MeasuredCell:
    """How different the episodes are that MAPPO plays with itself, as many as people have recorded, over maps."""
    agents = tuple(f"mappo-{number}@a" for number in range(1, len(map_names()) + 1))
    measurement = Measurement(
        name="diversity-of-equal-mappo",
        about="diversity of the episodes of MAPPO, equally many of each population",
        data=("c1", "c2"),
        perform=partial(_diversity, agents),
        agents=agents,
        repeated=True,
        pool=averaged,
        seconds=lambda budget: 10.0 + len(agents) * EPISODES * budget.ticks / LIMIT_TICKS,
    )
    return MeasuredCell(measurement, field, may_lack=True)


def _diversity(agents: tuple[str, ...], space: Workspace, training: int) -> Measured:
    sizes = equal_sizes(space)
    return diversity_over_maps(
        [
            (name, _path(with_seed(agent_id, training), name, seed, space.budget.ticks))
            for name, agent_id in zip(map_names(), agents, strict=True)
            for seed in range(sizes.get(name, 0))
        ],
        sizes,
    )


def _path(agent_id: str, name: str, seed: int, ticks: int) -> Floats:
    """(T + 1, 4) where both robots were in an episode."""
    steps = list(rollout(load_map(name), (load_agent(agent_id), load_agent(agent_id)), seed, ticks))
    states = [steps[0].before, *(step.after for step in steps)]
    return np.array([state.robot_poses[:, :2].reshape(4) for state in states])


def _alone(kind: str, number: int, measure: str) -> PlayedCell:
    plays = tuple(Play(f"{kind}-{number}@{seed}") for seed in "ab")
    return PlayedCell(plays, 1, measure, (map_names()[number - 1],))


def _behaviour(method: str, number: int, field: str) -> MeasuredCell:
    name = map_names()[number - 1]
    agents = f"{method}@a", f"{method}@b"
    measurement = Measurement(
        name=f"behaviour-{method}-{name}",
        about=f"how {method} behaves on {name}",
        episodes=_episodes,
        perform=partial(_measured, agents, number),
        agents=agents,
        repeated=True,
        seconds=lambda budget: 2.0 + len(agents) * EPISODES * budget.ticks / LIMIT_TICKS,
    )
    return MeasuredCell(measurement, field, may_lack=True)


def _episodes(budget: Budget) -> int:
    """Of each agent."""
    return max(EPISODES, budget.seeds)


def _measured(agents: tuple[str, ...], number: int, space: Workspace, training: int) -> Measured:
    values: dict[str, list[float]] = {}
    for agent_id in (with_seed(one, training) for one in agents):
        for seed in range(_episodes(space.budget)):
            for field, value in _of_episode(agent_id, number, seed, space.budget.ticks):
                values.setdefault(field, []).append(value)
    found = {field: estimate(numbers) for field, numbers in values.items()}
    return {field: one for field, one in found.items() if one is not None}


def _of_episode(agent_id: str, number: int, seed: int, ticks: int) -> Iterator[tuple[str, float]]:
    """The measures of an episode; those of which nothing happened are missing."""
    the_map = load_map(map_names()[number - 1])
    grasps: list[int] = []
    for step in rollout(the_map, (load_agent(agent_id), load_agent(agent_id)), seed, ticks):
        held = step.after.held.tolist()
        if not grasps and max(held) >= 0:
            grasps = [item for item in held if item >= 0]
            yield f"map_{number}_first_grasp_s", _seconds(step)
            middle = [the_map.items[item].size == "middle" for item in grasps]
            yield f"map_{number}_middle_first", sum(middle) / len(middle)
        if held[0] == held[1] >= 0:
            yield f"map_{number}_first_shared_s", _seconds(step)
            return


def _seconds(step: RolloutStep) -> float:
    return step.after.tick / TICKS_PER_SECOND
