"""BASS that simulates with the engine itself instead of a learned network: on any map, with nothing to train."""

from collections.abc import Callable, Sequence

import numpy as np

from movingout.agents.base import EpisodeInfo
from movingout.agents.bass.agent import BassAgent
from movingout.agents.bass.selection import Simulator
from movingout.agents.bass.state_vector import moving_arrays
from movingout.agents.errors import AgentError
from movingout.maps import MapSpec
from movingout.world import World
from movingout.world.physics import Snapshot
from movingout.world.state import Floats, WorldState


class EngineBassAgent(BassAgent):
    """Simulates with the engine, started from what is seen; after eight ticks a robot is about 0.002 off."""

    def reset(self, episode: EpisodeInfo) -> None:
        super().reset(episode)
        # that of every rollout
        self._world = World(episode.map, record_sub_poses=False, sub_steps=self.selection.sub_steps)

    @staticmethod
    def simulate_many(
        agents: Sequence[BassAgent], states: Sequence[WorldState], joints: Sequence[Floats]
    ) -> Sequence[Floats]:
        """States predicted by the engine, from each agent's state."""
        return [agent.simulator(state)(joint) for agent, state, joint in zip(agents, states, joints, strict=True)]

    def simulator(self, state: WorldState) -> Simulator:
        """The engine, started in a state."""

        def placed() -> World:
            self._world.place(state)
            return self._world

        return simulator_from(placed, levels=self.spec.grasp == "hold")


class OracleBassAgent(EngineBassAgent):
    """The upper bound: simulates exactly, with the engine. Needs access to the world, so only in headless matches."""

    def reset(self, episode: EpisodeInfo) -> None:
        super().reset(episode)
        self._watched: World | None = None

    def watch(self, world: World) -> None:
        """Be given the world that is played in; called once per episode, before the first tick."""
        self._watched = world

    def simulator(self, state: WorldState) -> Simulator:
        """The engine, started from the present state. Raises AgentError where it is not watched."""
        if self._watched is None:
            if state.tick > 0:
                raise AgentError("simulator=oracle needs the world itself; use it in headless matches only")
            return super().simulator(state)  # the warm-up decision of a worker
        return engine_simulator(self._watched.snapshot(), levels=self.spec.grasp == "hold")


def engine_simulator(moment: Snapshot, *, levels: bool) -> Simulator:
    """The true world from a snapshot on; each rollout simulates the episode so far again (50 us per tick)."""
    return simulator_from(lambda: _restored(moment.map, moment), levels=levels)


def _restored(map_spec: MapSpec, moment: Snapshot) -> World:
    world = World(map_spec, record_sub_poses=False)
    world.restore(moment)
    return world


def simulator_from(start: Callable[[], World], *, levels: bool) -> Simulator:
    """Simulates each rollout in the world that `start` returns; `levels`: grasps of chunks are wanted, not toggled."""

    def simulate(joint: Floats) -> Floats:
        actions = np.stack((joint[..., 0], np.arctan2(joint[..., 2], joint[..., 1]), joint[..., 3]), axis=-1)
        states = [state for chunk in actions for state in _rollout(start(), chunk, levels)]
        rows = moving_arrays(
            np.array([state.robot_poses for state in states]),
            np.array([state.robot_velocities for state in states]),
            np.array([state.held for state in states]),
            np.array([state.item_poses for state in states]),
        )
        return rows.reshape(*joint.shape[:2], -1)

    return simulate


def _rollout(world: World, actions: Floats, levels: bool) -> list[WorldState]:
    """The states after each of the actions (depth, 2, 3)."""
    states = [world.state()]
    for both in actions:
        if levels:
            both[:, 2] = both[:, 2] != (states[-1].held >= 0)
        world.step(both)
        states.append(world.state())
    return states[1:]
