"""Random and scripted baselines in the PettingZoo environment: `.venv/bin/python examples/pettingzoo_baselines.py`."""

from movingout.agents.base import EpisodeInfo
from movingout.agents.catalogue import load_agent
from movingout.agents.observation.seat_observation import observe
from movingout.world.env import MovingOutEnv


def run(env, policy):
    """One episode; `policy(seat, colour)` gives an action (4,). Returns the paper's metrics."""
    env.reset(seed=0)
    infos = {}
    while env.agents:
        _, _, _, _, infos = env.step({colour: policy(seat, colour) for seat, colour in enumerate(env.agents)})
    return {name: round(infos["blue"][name], 3) for name in ("tcr", "nfd", "wt_s", "ac")}


env = MovingOutEnv("DistancePriority", limit_ticks=200)
for colour in env.possible_agents:
    env.action_space(colour).seed(0)
print("random  ", run(env, lambda seat, colour: env.action_space(colour).sample()))

people = [load_agent("scripted"), load_agent("scripted")]
for seat, agent in enumerate(people):
    agent.reset(EpisodeInfo(env.map, seat, seed=0, ticks=200))
print("scripted", run(env, lambda seat, colour: people[seat].act(observe(env.map, env.world_state, seat))[0]))
