"""What is measured for tables besides matches: accuracy of the parts of BASS, noise that episodes stand, and time."""

import time
from functools import partial

from movingout.agents.base import EpisodeInfo
from movingout.agents.bass.accuracy import moment_values
from movingout.agents.bass.agent import BassAgent
from movingout.agents.bass.noise_validity import valid_after_noise
from movingout.agents.catalogue import load_agent
from movingout.agents.data.dataset import read_trajectories
from movingout.agents.observation.seat_observation import observe
from movingout.maps import load_map
from movingout.maps.suggestion import counted
from movingout.matches.errors import MatchError
from movingout.matches.paper.budgets import Budget
from movingout.matches.paper.cells import MeasuredCell, Measurement
from movingout.matches.paper.methods import NOISE_MAP, with_seed
from movingout.matches.paper.pooling import of_the_same_samples
from movingout.matches.paper.rows.unseen_episodes import EPISODES, unseen_episodes
from movingout.matches.paper.workspace import Measured, Workspace
from movingout.recordings.groups import listed_maps, read_groups
from movingout.world import World
from movingout.world.constants import LIMIT_TICKS
from movingout.world.estimates import estimate, estimate_of_copies

TIMED_MAP = "HandOff"
NOISE_SAMPLES = 2000  # perturbed states per level, at most; the paper has as many
DECISIONS = 20  # that are timed, after one that is not


def accuracy(method: str, options: str, challenge: int, field: str) -> MeasuredCell:
    """A field of `BassAccuracy` of an agent, on episodes of people that it has not learned from.

    In Challenge 1 an agent of group a, on episodes of group b; in Challenge 2, on the maps that it is evaluated on.
    """
    agent = f"{method}@{'a' if challenge == 1 else 'c2'}"
    name = f"accuracy-by-episode-{agent}{options}".translate(str.maketrans("@:=,", "----"))
    measurement = Measurement(
        name=name,
        about=f"accuracy of {agent}{options} on episodes of pairs in turn that it has not learned from",
        perform=partial(_accuracy, agent + options, challenge),
        agents=(agent,),
        data=("b",) if challenge == 1 else ("c1", "c2"),
        repeated=True,
        pool=of_the_same_samples,
        seconds=lambda budget: 5.0 + 12 * EPISODES * (1.5 + 0.2 * budget.moments) * budget.ticks / 500,
    )
    return MeasuredCell(
        measurement,
        field,
        may_lack=field == "selection_told_apart",  # perhaps in no moment
        of_first=field == "random_state_l2",  # says nothing of the agent: the same in every training
    )


def _accuracy(first: str, challenge: int, space: Workspace, training: int) -> Measured:
    agent_id = with_seed(first, training)
    agent = load_agent(agent_id)
    if not isinstance(agent, BassAgent):
        raise MatchError(f"{agent_id} is not a BASS agent: it has no simulator and no candidates")
    values = moment_values(agent, unseen_episodes(challenge, space), space.budget.moments, seed=space.seed)
    found = {name: estimate_of_copies(numbers) for name, numbers in values.items()}
    return {name: numbers for name, numbers in found.items() if numbers is not None}


def noise_validity(level: str) -> MeasuredCell:
    """The share of perturbed states on map 10 after which the recorded actions stay valid."""
    measurement = Measurement(
        name=f"noise-by-episode-{level}",
        about=f"validity of states of {NOISE_MAP} with pose noise {level}",
        perform=partial(_noise_validity, float(level)),
        data=("c1",),
        seconds=lambda budget: 2.0 + 0.006 * noise_samples(budget),
        samples=noise_samples,
    )
    return MeasuredCell(measurement, "valid_share")


def noise_samples(budget: Budget) -> int:
    """More than other states, which take longer."""
    return min(NOISE_SAMPLES, 5 * budget.states)


def _noise_validity(deviation: float, space: Workspace, training: int) -> Measured:
    rows = read_groups(space.listing("c1"))
    trajectories = read_trajectories([row.path for row in rows if row.map == NOISE_MAP])
    valid = valid_after_noise(trajectories, deviation, noise_samples(space.budget), space.seed)
    found = estimate_of_copies(valid)
    return {} if found is None else {"valid_share": found}


def noise_episodes(space: Workspace) -> list[str]:
    """On how many episodes its error rests, in a sentence; once they have been listed."""
    listing = space.listing("c1")
    number = listed_maps(listing)[NOISE_MAP] if listing.exists() else 0
    return [f"Here ± of valid rests on {counted(number, 'episode')} of {NOISE_MAP}."] if number else []


def decision_time(method: str, options: str) -> MeasuredCell:
    """How long a decision takes on one thread of this machine, in milliseconds."""
    agent = f"{method}@c1"
    measurement = Measurement(
        name=f"time-{method}{options}".translate(str.maketrans(":=,", "---")),
        about=f"time of a decision of {agent}{options}",
        perform=partial(_decision_time, agent + options),
        agents=(agent,),
        seconds=lambda budget: 5.0,
    )
    return MeasuredCell(measurement, "decision_ms")


def _decision_time(agent_id: str, space: Workspace, training: int) -> Measured:
    agent, the_map = load_agent(agent_id), load_map(TIMED_MAP)
    seen = observe(the_map, World(the_map).state(), 0)
    spent = []
    for _ in range(1 + DECISIONS):
        agent.reset(EpisodeInfo(the_map, 0, space.seed, LIMIT_TICKS))  # else it would go on with the chunk it has
        begun = time.perf_counter()
        agent.act(seen)
        spent.append(1000 * (time.perf_counter() - begun))
    found = estimate(spent[1:])
    return {} if found is None else {"decision_ms": found}
