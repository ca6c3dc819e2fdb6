"""Whether an agent keeps the contract of `agents.base.Agent`: to be run on a policy of one's own.

    from movingout import check_agent

    check_agent(lambda: MyPolicy("weights.npz"))

It plays a few short episodes and a whole one, and raises ConformanceError for the first thing that is wrong, saying
what would be right.
`movingout agents check my_package.policy:MyPolicy` does the same from the command line.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import zip_longest
from numbers import Integral

import numpy as np

from movingout.agents.action_chunk import checked_chunk, rows_to_execute, world_action
from movingout.agents.base import ActionChunk, Agent, BatchAgent, EpisodeInfo, Observation, Watcher, batch_group
from movingout.agents.data.rollout import check_undelivered
from movingout.agents.decision_time import unhindered
from movingout.agents.decision_trace import UNWRITABLE, decision_trace
from movingout.agents.errors import AgentError
from movingout.agents.factories import check_methods
from movingout.agents.fault_place import located
from movingout.agents.observation.seat_observation import observe, start_state
from movingout.maps import load_map
from movingout.maps.files.ctrl_c import FOREIGN_CODE_RAISES, is_ctrl_c, noticing_ctrl_c
from movingout.maps.spec import SEAT_COLOURS
from movingout.world import World
from movingout.world.constants import LIMIT_TICKS, MAX_TICKS
from movingout.world.state import Floats, Ints, WorldState

MAPS = ("HandOff", "FourCorners", "SingleRotation")
TICKS = 30  # of a short episode
WHOLE_S = 30.0  # of an agent's thinking: the whole episode ends here, so that slow agents are checked, too
SEED = 7
_APART = (
    "share nothing that changes with others: draw from a generator of your own, np.random.default_rng(episode.seed), "
    "and keep memory on self, not on the class or the module"
)


class ConformanceError(AgentError, AssertionError):
    """An agent does not keep the contract; the message says where, what, and what would be right."""


@dataclass(slots=True)
class Conformance:
    """What was seen of an agent that keeps the contract. Times are reported and not judged."""

    episodes: int = 0
    ticks: int = 0  # of the longest episode
    decisions_ms: list[float] = field(default_factory=list)
    deterministic: bool = True  # an agent that says otherwise (attribute `deterministic`) is not compared with itself

    def __repr__(self) -> str:
        """One line, for the end of a notebook's cell."""
        played = f"{len(self.decisions_ms)} decisions in {self.episodes} episodes of up to {self.ticks} ticks"
        times = f", p50 {self.p50_ms:.1f} ms, p99 {self.p99_ms:.1f} ms" if self.decisions_ms else ""
        return f"<Conformance: {played}{times}{'' if self.deterministic else ', not deterministic'}>"

    @property
    def p50_ms(self) -> float:
        """Median time of a decision."""
        return float(np.percentile(self.decisions_ms, 50))

    @property
    def p99_ms(self) -> float:
        """99th percentile of the time of a decision; a live room gives it less than 100 ms."""
        return float(np.percentile(self.decisions_ms, 99))


def check_agent(
    factory: Callable[[], Agent], maps: str | Sequence[str] = MAPS, ticks: int | None = None
) -> Conformance:
    """Play in both seats of each map and check everything that rooms and matches rely on.

    `factory` makes a new agent at each call. `maps`: names, or a single one. Episodes have `ticks`; by default `TICKS`,
    and then one more on the first map is played to its end, `LIMIT_TICKS`. Raises ConformanceError for the first fault,
    and AgentError for other arguments and for a map on which there is nothing to play.
    """
    maps = [maps] if isinstance(maps, str) else maps
    _check_arguments(factory, maps, ticks)
    whole, ticks = ticks is None, ticks or TICKS
    for name in maps:
        check_undelivered(load_map(name))
    found = Conformance()
    agent = _made(factory)
    found.deterministic = bool(getattr(agent, "deterministic", True))
    if _made(factory) is agent:
        raise ConformanceError("the factory returned the same object twice; make a new agent at each call")
    for name in maps:
        for seat in (0, 1):
            episode = EpisodeInfo(load_map(name), seat, SEED, ticks)
            first = _play(agent, episode, found)
            again, new = _play(agent, episode, found), _play(_made(factory), episode, found)
            if found.deterministic:
                _compare(first, again, episode, "after another reset", "forget the last episode")
                _compare(first, new, episode, "in a new agent", "draw from its seed alone")
            found.episodes += 3
    if found.deterministic:
        _check_side_by_side(factory, maps, ticks, found)
    if isinstance(agent, BatchAgent):
        _check_batch(factory, maps, ticks, found.deterministic)
    if whole:  # what happens late: an item delivered, a memory that is full
        _play(agent, EpisodeInfo(load_map(maps[0]), 0, SEED, LIMIT_TICKS), found, WHOLE_S)
        found.episodes += 1
    return found


def episode_answers(agent: Agent, episode: EpisodeInfo) -> list[ActionChunk]:
    """What an agent answers in an episode beside a partner who drives about. Raises ConformanceError."""
    return _play(agent, episode, Conformance())


def _check_arguments(factory: object, maps: Sequence[str], ticks: object) -> None:
    """Raises AgentError for what is no factory, for no map, and for a wrong number of ticks."""
    if isinstance(factory, str):
        raise AgentError(f"give what makes the agent, not its id: check_agent(lambda: load_agent({factory!r}))")
    if not isinstance(factory, type) and hasattr(factory, "reset") and hasattr(factory, "act"):
        raise AgentError("give what makes the agent, its class or a function, not an agent that is made already")
    if not maps:
        raise AgentError("name a map to play on")
    if ticks is not None and (
        isinstance(ticks, bool) or not isinstance(ticks, Integral) or not 1 <= int(ticks) <= MAX_TICKS
    ):
        raise AgentError(f"ticks is a whole number from 1 to {MAX_TICKS}, not {ticks!r:.80}")


def _made(factory: Callable[[], Agent]) -> Agent:
    with _blamed("the factory"):
        agent = factory()
    try:
        check_methods(agent, "the factory")
    except AgentError as error:
        raise ConformanceError(str(error)) from None
    return agent


def _play(agent: Agent, episode: EpisodeInfo, found: Conformance, longest_s: float = math.inf) -> list[ActionChunk]:
    """The checked answers to all questions of an episode."""
    _reset_twice(agent, episode)
    return list(_answers(agent, episode, found, longest_s))


def _answers(
    agent: Agent, episode: EpisodeInfo, found: Conformance, longest_s: float = math.inf
) -> Iterator[ActionChunk]:
    """The same of an agent that has been reset, beside a partner who drives about: as they are given."""
    world = World(episode.map, record_sub_poses=False)
    if isinstance(agent, Watcher):
        agent.watch(world)
    random = np.random.default_rng(SEED)
    waiting: list[Floats] = []
    began = len(found.decisions_ms)
    while world.tick < episode.ticks and not world.delivered().all():
        state = world.state()
        if not waiting:
            if sum(found.decisions_ms[began:]) > longest_s * 1e3:
                break
            answer = _decided(agent, state, episode, found)
            yield answer
            waiting = list(answer[: _rows(agent, answer, episode)])
        both = np.zeros((2, 3))
        both[episode.seat] = world_action(waiting.pop(0))
        both[1 - episode.seat] = random.uniform(0.0, 1.0), random.uniform(-np.pi, np.pi), random.random() < 0.1
        world.step(both)
    found.ticks = max(found.ticks, world.tick)


def _reset_twice(agent: Agent, episode: EpisodeInfo) -> None:
    """A room resets an agent when it is seated, and again when the round begins."""
    with _blamed(f"{_place(episode)}: reset"):
        agent.reset(episode)
    with _blamed(f"{_place(episode)}: a second reset"):
        agent.reset(episode)


def _decided(agent: Agent, state: WorldState, episode: EpisodeInfo, found: Conformance) -> ActionChunk:
    """One answer, checked."""
    where = f"{_place(episode)}, tick {state.tick}"
    before = _copied(state)
    with _blamed(f"{where}: act"):
        began = unhindered()
        answer = agent.act(observe(episode.map, state, episode.seat))
        found.decisions_ms.append((unhindered() - began) * 1e3)
    if not _equal(before, state):
        raise ConformanceError(f"{where}: act changed the observation's arrays; copy them before you write")
    _check_ranges(answer, where)
    trace = decision_trace(agent)
    if UNWRITABLE in trace:
        raise ConformanceError(f"{where}: `detail` cannot be written as JSON ({trace[UNWRITABLE]}); use plain values")
    return np.asarray(answer, dtype=np.float64).copy()


def _check_ranges(answer: object, where: str) -> None:
    """Shape, finiteness and heading as at the rim of a room; and the ranges that a room would clip to."""
    try:
        checked_chunk(answer)
    except AgentError as error:
        raise ConformanceError(f"{where}: {error}") from error
    chunk = np.asarray(answer, dtype=np.float64)
    if np.abs(chunk[:, 0]).max() > 1.0:
        worst = chunk[np.abs(chunk[:, 0]).argmax(), 0]
        raise ConformanceError(f"{where}: distance {float(worst)!r} in column 0; clip it to -1 to 1")
    if not np.isin(chunk[:, 3], (0.0, 1.0)).all():
        worst = chunk[~np.isin(chunk[:, 3], (0.0, 1.0)), 3][0]
        raise ConformanceError(f"{where}: grasp toggle {float(worst)!r} in column 3; it is 1 to press and 0 not to")


def _rows(agent: Agent, chunk: ActionChunk, episode: EpisodeInfo) -> int:
    """How many rows to play before the agent is asked again."""
    try:
        return rows_to_execute(agent, chunk)
    except AgentError as error:
        raise ConformanceError(f"{_place(episode)}: {error}") from error


def _compare(
    one: Sequence[ActionChunk], other: Sequence[ActionChunk], episode: EpisodeInfo, when: str, advice: str
) -> None:
    """The same episode gives the same answers to the bit."""
    same = [np.array_equal(a, b) for a, b in zip(one, other, strict=False)]
    if len(one) != len(other) or not all(same):
        number = same.index(False) if False in same else min(len(one), len(other))
        raise ConformanceError(
            f"{_place(episode)}: decision {number + 1} is another {when}, for the same map, seat and seed; "
            f"an agent should {advice}"
        )


def _check_side_by_side(factory: Callable[[], Agent], maps: Sequence[str], ticks: int, found: Conformance) -> None:
    """Matches of one process advance together, tick by tick: an agent answers beside its like as it does alone."""
    episodes = [
        EpisodeInfo(load_map(maps[0]), 0, SEED, ticks),
        EpisodeInfo(load_map(maps[-1]), 1, SEED + 1, ticks),
    ]
    alone = [_play(_made(factory), episode, found) for episode in episodes]
    agents = [_made(factory) for _ in episodes]
    for agent, episode in zip(agents, episodes, strict=True):
        _reset_twice(agent, episode)
    both = [_answers(agent, episode, found) for agent, episode in zip(agents, episodes, strict=True)]
    turns = list(zip_longest(*both))
    for episode, expected, answers in zip(episodes, alone, zip(*turns, strict=True), strict=True):
        given = [answer for answer in answers if answer is not None]
        _compare(expected, given, episode, "while another one plays", _APART)
    found.episodes += 4


def _check_batch(factory: Callable[[], Agent], maps: Sequence[str], ticks: int, deterministic: bool) -> None:
    """Agents that answer together (`BatchAgent`) answer as they would alone; if not deterministic, with chunks."""
    episodes = [EpisodeInfo(load_map(name), seat, SEED, ticks) for name in maps for seat in (0, 1)]
    alone, together = ([_made(factory) for _ in episodes] for _ in range(2))
    asked: list[Observation] = []
    for episode, *agents in zip(episodes, alone, together, strict=True):
        for agent in agents:
            _reset_twice(agent, episode)
        asked.append(observe(episode.map, start_state(episode.map), episode.seat))
    expected = [agent.act(observation) for agent, observation in zip(alone, asked, strict=True)]
    first = together[0]
    assert isinstance(first, BatchAgent)
    with _blamed("batch_key"):
        groups = [batch_group(agent) for agent in together]
    rows = [row for row, group in enumerate(groups) if group == groups[0]]
    with _blamed("act_many"):
        answers = list(first.act_many([together[row] for row in rows], [asked[row] for row in rows]))
    if len(answers) != len(rows):
        raise ConformanceError(f"act_many gave {len(answers)} answers to {len(rows)} agents; it gives one to each")
    for row, answer in zip(rows, answers, strict=True):
        place, one = _place(episodes[row]), expected[row]
        if not deterministic:
            _check_ranges(answer, f"{place}: act_many")
        elif not np.array_equal(answer, one):
            raise ConformanceError(f"{place}: act_many answers otherwise than act; both agree to the bit")


@contextmanager
def _blamed(what: str) -> Iterator[None]:
    """Whatever the agent's own code raises becomes a ConformanceError that says in which call."""
    with noticing_ctrl_c():
        try:
            yield
        except AgentError as error:  # its sentence names the place already
            raise ConformanceError(f"{what} raised {type(error).__name__}: {error}") from error
        except FOREIGN_CODE_RAISES as error:
            if is_ctrl_c(error):
                raise
            raise ConformanceError(located(f"{what} raised {type(error).__name__}: {error}", error)) from error


def _place(episode: EpisodeInfo) -> str:
    return f"{episode.map.name}, {SEAT_COLOURS[episode.seat]}"


def _copied(state: WorldState) -> tuple[Floats | Ints, ...]:
    return tuple(array.copy() for array in _arrays(state))


def _equal(before: tuple[Floats | Ints, ...], state: WorldState) -> bool:
    return all(np.array_equal(a, b) for a, b in zip(before, _arrays(state), strict=True))


def _arrays(state: WorldState) -> tuple[Floats | Ints, ...]:
    return state.robot_poses, state.robot_velocities, state.held, state.item_poses
