"""The agent `llm:`: asks a language model what to do, and does it with scripted skills while the answers come.

The live agent is not deterministic: models are not, and an answer counts from the tick at which it arrives. With `wait`
the match stands still until the answer is there, so that scores do not depend on the speed of the machine.
"""

import os
import time
import warnings
from collections import Counter
from collections.abc import Callable, Mapping

import numpy as np

from movingout.agents.base import ActionChunk, EpisodeInfo, Observation
from movingout.agents.errors import AgentError
from movingout.agents.fault_place import writable
from movingout.agents.llm.answers import ALONE, INSTRUCTIONS, ModelAnswer, Skill, UselessAnswerError, read_answer
from movingout.agents.llm.chat import Chat, ChatEndpoint, Message
from movingout.agents.llm.model_id import COUNTED, KEY, endpoint_key, model_id
from movingout.agents.llm.questions import ChatOutcome, Questions
from movingout.agents.llm.skill_choice import SkillSelector
from movingout.agents.scripted.agent import ScriptedAgent
from movingout.maps.suggestion import counted
from movingout.world.constants import TICKS_PER_SECOND
from movingout.world.ping import HelpPing
from movingout.world.scoring import delivered_items

FALLBACKS = ("help", "wait", ALONE)
MAX_RECORDED = 4000  # characters of a prompt or an answer in the decision trace
TOLD_FOR = 2  # ticks for which the trace has an exchange: a decision that comes late is not recorded
SILENT = 3  # questions of an episode without one useful answer, after which a warning says so
VAIN = 10  # questions without one useful answer, or time-outs in a row, after which a match that waits for them ends
SOON = 5  # ticks between two questions when nothing of the last answer is left to do
LONGEST_WAIT_S = 9.5  # a match gives a decision 20 s, and the server may ask for a pause of the same length


class LlmAgent(ScriptedAgent):
    """A scripted agent whose tasks are chosen by a language model."""

    deterministic = False

    def __init__(
        self,
        chat: Chat,
        timeout_s: float,
        every_s: float,
        fallback: str = "help",
        waits: bool = False,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        """`every_s`: of play between two questions at least. `fallback`: what is done without an answer."""
        super().__init__()
        self.waits = waits
        self._fallback = Skill(fallback, ticks=TICKS_PER_SECOND)
        self._every = max(1, round(every_s * TICKS_PER_SECOND))
        self._questions = Questions(chat, timeout_s, clock, sleep)

    def reset(self, episode: EpisodeInfo) -> None:
        """Begin an episode; an answer that is on its way is for the last one."""
        super().reset(episode)
        self._skill_choice = SkillSelector(episode.map, self.style, self._fallback)
        self._selector = self._skill_choice
        self._heavy = frozenset(index for index, item in enumerate(episode.map.items) if item.size != "small")
        self._questions.forget()
        self._asked_at = -self._every
        self._prompt = self._plan = self._note = ""
        self._remarks: list[str] = []  # for the next question: what was wrong with the last answer
        self._counts = Counter({"questions": 0})  # what has none is of an earlier version
        self._timeouts = 0  # in a row
        self._told: dict[str, object] = {}
        self._told_until = -1

    def act(self, observation: Observation) -> ActionChunk:
        """A chunk of one row. Afterwards `detail` has task, skill and plan, and an exchange that has just ended."""
        self._converse(observation)
        chunk = super().act(observation)
        self.detail |= {"skill": str(self._skill_choice.skill), "plan": self._plan}
        if observation.tick < self._told_until:
            self.detail |= self._told
        return chunk

    @property
    def episode_counts(self) -> dict[str, int]:
        """Questions with an outcome, useful answers and faults of the episode."""
        return {COUNTED + name: count for name, count in self._counts.items()}

    @property
    def plan(self) -> str:
        """The plan of the last useful answer of the episode, in words; empty before."""
        return self._plan

    @property
    def not_played(self) -> str:
        """Why the episode is not the model's: each answer was waited for, and none was usable; else empty."""
        asked = self._counts["questions"]
        if not self.waits or not asked or self._counts["useful"]:
            return ""
        return f"not one usable answer to {counted(asked, 'question')} ({self._note:.200}), so only its fallback played"

    def _converse(self, observation: Observation) -> None:
        """Take over an answer that has come, and ask again in time.

        The first tick is without a question: rooms try agents on it before anybody plays.
        """
        outcome = self._questions.poll()
        if outcome is not None:
            self._take(outcome, observation)
        self._remarks += self._skill_choice.failures()
        due = self._asked_at + (self._every if self._skill_choice.has_skills else min(self._every, SOON))
        if observation.state.tick == 0 or observation.tick < due or not (self.waits or self._questions.ready):
            return
        self._asked_at = observation.tick
        if self.waits:
            self._check_answers()
            self.ask_and_wait(observation)
        else:
            self._questions.ask(self._messages(observation))

    def _check_answers(self) -> None:
        """Raises AgentError where no answer is to be expected: each costs as much time as an agent may take."""
        if self._counts["questions"] >= VAIN and (why := self.not_played):
            raise AgentError(why)
        if self._timeouts >= VAIN:
            raise AgentError(f"no answer to {counted(self._timeouts, 'question')} in a row ({self._note:.200})")

    def ask_and_wait(self, observation: Observation) -> Mapping[str, object]:
        """Ask now, whatever `waits` says, and take over the answer; returns what the trace has of it."""
        self._take(self._questions.wait(self._messages(observation)), observation)
        return self._told

    def _messages(self, observation: Observation) -> list[Message]:
        lines = [str(observation.describe())]
        lines += [f"Your partner asks for help {_where(ping.item)}." for ping in self._their_pings(observation)]
        if self._plan:
            lines.append(f"Your last plan: {self._plan}")
        lines.append(f"You are doing: {self._skill_choice.skill}.")
        lines += [f"Not done: {remark}." for remark in self._remarks[-5:]]
        self._remarks = []
        self._prompt = "\n".join(lines)
        return [{"role": "system", "content": INSTRUCTIONS}, {"role": "user", "content": self._prompt}]

    def _their_pings(self, observation: Observation) -> list[HelpPing]:
        return [ping for ping in observation.pings if ping.seat != observation.seat][-1:]

    def _take(self, outcome: ChatOutcome, observation: Observation) -> None:
        """Do what the answer says; without one, go on with what is being done."""
        note = outcome.problem
        self._counts["questions"] += 1  # not when it is asked: the last one of an episode may stay open
        self._counts[outcome.fault or "answers"] += 1
        self._timeouts = self._timeouts + 1 if outcome.fault == "timeout" else 0
        if outcome.fault is None:
            try:
                answer = self._read(outcome.answer, observation)
            except UselessAnswerError as error:
                self._counts["rubbish"] += 1
                self._remarks.append(str(error))
                note = str(error)
            else:
                note = "; ".join(answer.left_out)
                self._remarks += answer.left_out
                self._counts["useful"] += 1
                self._counts["left_out"] += len(answer.left_out)
                self._plan = answer.plan or "Next: " + ", ".join(map(str, answer.skills)) + "."
                self._skill_choice.choose(answer.skills)
        self._note = note
        self._warn(note)
        self._told_until = observation.tick + TOLD_FOR
        self._told = {
            "question": self._counts["questions"],
            "prompt": self._prompt[:MAX_RECORDED],
            "answer": writable(outcome.answer)[:MAX_RECORDED],
            "latency_s": round(outcome.latency_s, 3),
            "fault": outcome.fault or "",
            "note": writable(note)[:MAX_RECORDED],
            "counts": dict(self._counts),
        }
        if self._counts["questions"] == 1:
            self._told["instructions"] = INSTRUCTIONS

    def _warn(self, note: str) -> None:
        """Say that the fallback plays: without it, the scores of a match would be taken for the model's."""
        if not self._plan and self._counts["questions"] == SILENT:
            sentence = f"llm: no usable answer to {SILENT} questions ({note:.200}); meanwhile its fallback plays"
            warnings.warn(sentence, RuntimeWarning, stacklevel=2)

    def _read(self, text: str, observation: Observation) -> ModelAnswer:
        done = delivered_items(self._map, observation.state.item_poses)
        delivered = frozenset(np.flatnonzero(done).tolist())
        return read_answer(text, len(self._map.items), delivered, self._heavy)


def _where(item: int) -> str:
    return "where it is" if item < 0 else f"with item {item}"


def llm_agent(
    model: str = "",
    url: str = "",
    wait: bool | str = False,
    timeout: float = 8.0,
    every: float = 2.0,
    fallback: str = "help",
    temperature: float | str = "",
    tokens: int = 0,
) -> LlmAgent:
    """The agent of an id `llm:model=…,url=…`; the key comes from the environment.

    Raises AgentError: an option that cannot be, a missing package, or nothing that answers at `url`.
    """
    which, waits = model_id(model, url), _yes("wait", wait)
    longest = LONGEST_WAIT_S if waits else 60.0
    timeout_s, every_s = _between("timeout", timeout, 0.1, longest), _between("every", every, 0.1, 60.0)
    if fallback not in FALLBACKS:
        raise AgentError(f"llm: fallback is one of {', '.join(FALLBACKS)}, not {fallback!r}")
    extra: dict[str, float] = {}
    if temperature != "":
        extra["temperature"] = _between("temperature", temperature, 0.0, 2.0)
    if tokens:
        extra["max_tokens"] = int(_between("tokens", tokens, 16, 100_000))
    endpoint = ChatEndpoint(which, endpoint_key(os.environ.get(KEY, "")), timeout_s, extra)
    endpoint.meet()
    return LlmAgent(endpoint, timeout_s, every_s, fallback, waits)


def _yes(name: str, value: object) -> bool:
    if value in (True, "yes"):
        return True
    if value in (False, "no"):
        return False
    raise AgentError(f"llm: {name} is yes or no, not {value!r}")


def _between(name: str, value: object, low: float, high: float) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        raise AgentError(f"llm: {name} lies between {low:g} and {high:g}, not {value!r}")
    return value
