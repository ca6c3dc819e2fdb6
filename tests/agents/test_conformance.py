"""`check_agent` accepts every agent that comes with the project, and says of a broken one what is wrong."""

import json
import random
from collections.abc import Callable, Hashable, Sequence
from itertools import count
from typing import Any, ClassVar

import numpy as np
import pytest

from movingout import check_agent
from movingout.agents.base import ActionChunk, Agent, EpisodeInfo, Observation
from movingout.agents.baseline.idle import IdleAgent
from movingout.agents.catalogue import agent_cards, load_agent
from movingout.agents.conformance import Conformance, ConformanceError
from movingout.maps import MovingOutError
from movingout.server.cli import main
from tests.agents.support import HERE, Forward

FEW_TICKS = 8


@pytest.mark.parametrize("agent_id", [*(card.id for card in agent_cards()), "dp@all:lag=2"])
def test_the_agents_of_the_project_keep_the_contract(agent_id: str) -> None:
    found = check_agent(lambda: load_agent(agent_id), ticks=FEW_TICKS)
    assert found.episodes == 22 and 0.0 <= found.p50_ms <= found.p99_ms


def test_what_was_seen_is_one_line_at_the_end_of_a_cell() -> None:
    found = Conformance(episodes=2, ticks=30, decisions_ms=[1.0] * 60)
    assert repr(found) == "<Conformance: 60 decisions in 2 episodes of up to 30 ticks, p50 1.0 ms, p99 1.0 ms>"
    assert repr(Conformance(deterministic=False)).endswith("of up to 0 ticks, not deterministic>")


def _answers(*row: float) -> Callable[[], Agent]:
    class Answering(Forward):
        def act(self, observation: Observation) -> ActionChunk:
            return np.array([row])

    return Answering


class Impatient(Forward):
    def reset(self, episode: EpisodeInfo) -> None:
        if hasattr(self, "episode"):
            raise RuntimeError("I am playing already")
        super().reset(episode)


class Writing(Forward):
    def act(self, observation: Observation) -> ActionChunk:
        observation.state.robot_poses.flags.writeable = True
        observation.state.robot_poses[0] = 0.0
        return super().act(observation)


class Forgetful(Forward):
    """Goes on with the random numbers of the last episode."""

    random = None

    def reset(self, episode: EpisodeInfo) -> None:
        self.random = self.random or np.random.default_rng(episode.seed)

    def act(self, observation: Observation) -> ActionChunk:
        assert self.random is not None
        return np.array([[self.random.random(), 1.0, 0.0, 0.0]])


class Seeding(Forward):
    """Seeds the random numbers of the whole process."""

    def reset(self, episode: EpisodeInfo) -> None:
        random.seed(episode.seed)

    def act(self, observation: Observation) -> ActionChunk:
        return np.array([[random.random(), 1.0, 0.0, 0.0]])


class Remembering(Forward):
    """Keeps what it has seen on its class."""

    seen: ClassVar[list[int]] = []

    def reset(self, episode: EpisodeInfo) -> None:
        self.seen.clear()

    def act(self, observation: Observation) -> ActionChunk:
        self.seen.append(observation.tick)
        return np.array([[1.0 / len(self.seen), 1.0, 0.0, 0.0]])


class Numbered(Forward):
    """Each one drives a little faster than the one before."""

    numbers = count(1)

    def __init__(self) -> None:
        super().__init__(distance=1.0 / next(self.numbers))


class Closed(Forward):
    def __init__(self) -> None:
        super().__init__()
        self.detail = {"raw": b"x"}  # type: ignore[dict-item]


class Crowding(IdleAgent):
    """Turns round where it answers together with others."""

    @staticmethod
    def act_many(agents: Sequence[IdleAgent], observations: Sequence[Observation]) -> list[ActionChunk]:
        return [np.tile([0.0, -1.0, 0.0, 0.0], (10, 1)) for _ in agents]


class Drawing(IdleAgent):
    """Draws anew in every call, alone and together, and says so."""

    deterministic = False
    many: ClassVar[tuple[float, ...]] = (1.0, 1.0, 0.0, 0.0)

    def act(self, observation: Observation) -> ActionChunk:
        return np.array([[random.random(), 1.0, 0.0, 0.0]])

    @classmethod
    def act_many(cls, agents: Sequence[IdleAgent], observations: Sequence[Observation]) -> list[ActionChunk]:
        return [random.random() * np.array([cls.many]) for _ in agents]


class DrawingMuch(Drawing):
    many = (1.0, np.nan, 0.0, 0.0)


class Listed(IdleAgent):
    @property
    def batch_key(self) -> Hashable:
        return ["mine"]  # type: ignore[return-value]


class Stuck(Forward):
    def __init__(self) -> None:
        super().__init__(execute=0)


class Leaving(Forward):
    """Ends the program instead of answering."""

    def act(self, observation: Observation) -> ActionChunk:
        raise SystemExit(3)


class Interrupting(Forward):
    """Raises what Ctrl-C raises."""

    def act(self, observation: Observation) -> ActionChunk:
        raise KeyboardInterrupt


ONE = Forward()


@pytest.mark.parametrize(
    ("factory", "sentence"),
    [
        (lambda: ONE, "the factory returned the same object twice; make a new agent at each call"),
        (object, "the factory returns object, which has no reset()"),
        (lambda: 1 / 0, "the factory raised ZeroDivisionError: division by zero"),
        (Impatient, "HandOff, blue: a second reset raised RuntimeError: I am playing already"),
        (_answers(0.5, 1.0, 0.0), r"HandOff, blue, tick 0: an action chunk has shape \(H, 4\)"),
        (_answers(np.nan, 1.0, 0.0, 0.0), "tick 0: an action chunk must hold finite numbers"),
        (_answers(0.5, 0.0, 0.0, 0.0), "cosine and sine of the heading, never both 0"),
        (_answers(1.5, 1.0, 0.0, 0.0), "distance 1.5 in column 0; clip it to -1 to 1"),
        (_answers(1.0000001, 1.0, 0.0, 0.0), "distance 1.0000001 in column 0"),
        (_answers(1.0, 1.0, 0.0, 0.99999999), "grasp toggle 0.99999999 in column 3"),
        (_answers(1.0, 1.0, 0.0, 0.7), "grasp toggle 0.7 in column 3; it is 1 to press and 0 not to"),
        (Writing, "act changed the observation's arrays; copy them before you write"),
        (Forgetful, "decision 1 is another after another reset, .* should forget the last episode"),
        (Numbered, "decision 1 is another in a new agent, .* should draw from its seed alone"),
        (Seeding, "HandOff, blue: decision 1 is another while another one plays, .* should share nothing that changes"),
        (Remembering, "HandOff, blue: decision 2 is another while another one plays, .* keep memory on self, not on"),
        (Closed, "`detail` cannot be written as JSON .*bytes.*; use plain values"),
        (Leaving, "HandOff, blue, tick 0: act raised SystemExit: 3"),
        (Interrupting, "HandOff, blue, tick 0: act raised KeyboardInterrupt"),
        (Stuck, "execute_rows is 0; it is a whole number of rows from 1"),
        (Listed, r"batch_key raised AgentError: batch_key is no value that can be hashed \(unhashable type: 'list'\)"),
        (Crowding, "HandOff, blue: act_many answers otherwise than act"),
        (DrawingMuch, "HandOff, blue: act_many: an action chunk must hold finite numbers"),
    ],
)
def test_a_broken_agent_is_told_what_is_wrong_and_what_would_be_right(
    factory: Callable[[], Agent], sentence: str
) -> None:
    with pytest.raises(ConformanceError, match=sentence) as raised:
        check_agent(factory, ticks=FEW_TICKS)
    assert isinstance(raised.value, AssertionError)


def test_who_is_not_deterministic_need_not_answer_together_as_alone() -> None:
    assert not check_agent(Drawing, "HandOff", ticks=2).deterministic


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("scripted",), r"not its id: check_agent\(lambda: load_agent\('scripted'\)\)"),
        ((ONE,), "its class or a function, not an agent that is made already"),
        ((Forward, []), "name a map to play on"),
        ((Forward, "H"), "unknown map 'H'"),
        *(((Forward, "HandOff", ticks), "ticks is a whole number from 1 to 36000") for ticks in (-3, 0, 2.5, True)),
    ],
)
def test_other_arguments_are_refused_in_a_sentence(arguments: tuple[Any, ...], sentence: str) -> None:
    with pytest.raises(MovingOutError, match=sentence) as raised:
        check_agent(*arguments)
    assert not isinstance(raised.value, ConformanceError)


def test_a_single_map_is_one() -> None:
    assert check_agent(Forward, "HandOff", ticks=2).episodes == 10


class Late(Forward):
    """Fails where short episodes have ended."""

    def act(self, observation: Observation) -> ActionChunk:
        if observation.tick == 300:
            raise IndexError("the memory is full")
        return super().act(observation)


def test_at_the_end_a_whole_episode_is_played() -> None:
    with pytest.raises(ConformanceError, match="HandOff, blue, tick 300: act raised IndexError: the memory is full"):
        check_agent(Late, ["HandOff"])
    assert check_agent(Late, ["HandOff"], 30).ticks == 30
    found = check_agent(Forward, ["HandOff"])
    assert (found.episodes, found.ticks) == (11, 500)


def test_an_agent_that_thinks_for_long_is_not_asked_to_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("movingout.agents.conformance.WHOLE_S", 0.0)
    found = check_agent(Forward, ["HandOff"])
    assert (found.episodes, found.ticks) == (11, 30)


def test_the_command_says_yes_or_no(capsys: pytest.CaptureFixture[str]) -> None:
    short = "--map", "HandOff", "--ticks", "4", "--json"
    assert main(["agents", "check", "idle", *short]) == 0
    assert json.loads(capsys.readouterr().out)["conforms"] is True
    assert main(["agents", "check", f"{HERE}:NotANumber", *short]) == 1
    problem = json.loads(capsys.readouterr().out)["problem"]
    assert problem == "HandOff, blue, tick 1: an action chunk must hold finite numbers; this one has NaN or infinity"
    assert main(["agents", "check", "nobody", *short]) == 2
