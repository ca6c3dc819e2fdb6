"""The process in which agents decide: one thread, earliest deadline first. It knows neither rooms nor browsers.

Requests that wait at the same time for agents with the same networks are answered in one batch.

Started by `server.agent_workers.process` with the arguments SOCKET_FD HEARTBEAT_FD CORES;
ends when the socket closes, and when an agent computes more than CORES in threads of its own, which nothing else ends.
"""

import contextlib
import os
import resource
import select
import signal
import socket
import statistics
import time
from collections import deque
from collections.abc import Hashable
from dataclasses import dataclass

from movingout.agents.action_chunk import checked_chunk, rows_to_execute
from movingout.agents.base import ActionChunk, Agent, BatchAgent, EpisodeInfo, Observation, batch_group
from movingout.agents.catalogue import load_live_agent
from movingout.agents.checkpoint.checkpoint import fingerprint
from movingout.agents.decision_time import first_decisions
from movingout.agents.decision_trace import decision_trace
from movingout.agents.errors import AgentError, TooSlowError
from movingout.agents.fault_place import located, writable
from movingout.agents.observation.seat_observation import observe, start_state
from movingout.agents.worker.heartbeat import WorkerHeartbeat
from movingout.agents.worker.messages import (
    Close,
    Failed,
    FrameBuffer,
    FromWorker,
    Observe,
    Open,
    Opened,
    Skipped,
    ToWorker,
    answer_message,
    frame,
    observed_state,
    read_to_worker,
)
from movingout.agents.worker.parent_process import end_with_parent
from movingout.agents.worker.thread_budget import ThreadBudget
from movingout.maps import MapSpec, Rect, is_reserved
from movingout.maps.files.ctrl_c import FOREIGN_CODE_RAISES
from movingout.world.constants import TICK_SECONDS

IDLE_WAIT_S = 0.5  # interval of an idle worker's heartbeat
GIVE_UP_AFTER = 20  # consecutive failures after which a seat is not asked again
MOST_MEMORY = 6 << 30  # bytes of one worker
MOST_GROUNDS = 200  # on which it is known that an agent was timed
MOST_SPARE, MOST_SPARE_IDS = 64, 8  # agents kept for later seats, and different ones; the oldest are dropped
OVERRUN = 4  # exit code
MAX_BATCH = 10  # requests answered together; more would delay the first of them too much


@dataclass(slots=True)
class _Seat:
    agent: Agent
    kept_as: "_Kept"
    episode: EpisodeInfo
    group: Hashable  # of the agents that answer together with it; None for one that answers alone
    failures: int = 0


_Kept = tuple[str, str]
"""An agent's id and the fingerprint of its checkpoint: after another training it is another agent."""

_Ground = tuple[tuple[Rect, ...], tuple[Rect, ...]]
"""Walls and goals of a map that people made; those of all maps that come with the project count as one."""


class DecisionQueue:
    """The seats of one worker and their open requests; knows no socket."""

    def __init__(self, heartbeat: WorkerHeartbeat, budget: ThreadBudget | None = None) -> None:
        self._heartbeat = heartbeat
        self._budget = ThreadBudget() if budget is None else budget
        self._seats: dict[int, _Seat] = {}
        self._questions: dict[int, Observe] = {}
        self._spare: dict[_Kept, list[Agent]] = {}
        self._timed_on: deque[tuple[_Kept, _Ground, bool]] = deque(maxlen=MOST_GROUNDS)

    @property
    def busy(self) -> bool:
        """Whether a request is waiting."""
        return bool(self._questions)

    def take(self, message: ToWorker) -> FromWorker | None:
        """Accept a message; opening a seat loads its agent at once."""
        match message:
            case Open():
                return self._open(message)
            case Observe():
                if message.key in self._seats:
                    self._questions[message.key] = message
            case Close():
                self._questions.pop(message.key, None)
                seat = self._seats.pop(message.key, None)
                if seat is not None and seat.failures == 0:
                    self._keep_spare(seat)
        return None

    def overrun(self) -> Failed | None:
        """The last word of this worker: an agent's threads compute too much. Its key is -1 for one without a seat."""
        found = self._budget.overrun()
        if found is None:
            return None
        key = next((key for key, seat in self._seats.items() if seat.agent is found.agent), -1)
        self._heartbeat.write("overrun", key)
        reason = f"the agent's own threads took {found.cores:.1f} cores, and {self._budget.most:g} are allowed"
        return Failed(key, -1, reason, fatal=True)

    def answer_next(self, now: float) -> list[FromWorker]:
        """Answer the request with the earliest deadline (there is one: see `busy`), and those of its batch."""
        question = min(self._questions.values(), key=lambda waiting: waiting.deadline)
        if now > question.deadline:
            del self._questions[question.key]
            return [Skipped(question.key, question.tick)]
        asked = self._together(question, now)
        for one in asked:
            del self._questions[one.key]
        self._heartbeat.write("deciding", question.key)
        if len(asked) > 1 and (answers := self._decide_together(asked)) is not None:
            return answers
        return [self._decide(self._seats[one.key], one) for one in asked]

    def _together(self, question: Observe, now: float) -> list[Observe]:
        """The request and others, still in time, for agents with the same networks; earliest deadlines first."""
        group = self._seats[question.key].group
        if group is None:
            return [question]
        others = [
            other
            for other in self._questions.values()
            if other is not question and now <= other.deadline and self._seats[other.key].group == group
        ]
        return [question, *sorted(others, key=lambda other: other.deadline)[: MAX_BATCH - 1]]

    def _open(self, message: Open) -> FromWorker:
        self._heartbeat.write("loading", message.key)
        episode = EpisodeInfo(message.map, message.seat, message.seed, message.ticks)
        try:
            kept_as = message.agent_id, fingerprint(message.agent_id)
            spare, share, ground = self._spares(kept_as), 0.0, _ground(episode.map)
            known = bool(spare) and self._was_timed(kept_as, ground, message.must_keep_up)
            with self._budget.loading():
                agent = spare.pop() if spare else _warm(load_live_agent(message.agent_id), episode)
                if not known:
                    share, keeps_up = _timed(message.agent_id, agent, episode, message.must_keep_up)
                    self._timed_on.append((kept_as, ground, keeps_up))
            agent.reset(episode)
            self._budget.claim(agent)
            group = batch_group(agent)
        except FOREIGN_CODE_RAISES as error:  # the boundary around an agent; Ctrl-C does not reach this process
            slow = isinstance(error, TooSlowError)
            return Failed(message.key, -1, _sentence(error), fatal=True, slow=slow)
        self._seats[message.key] = _Seat(agent, kept_as, episode, group)
        return Opened(message.key, share)

    def _was_timed(self, kept_as: _Kept, ground: _Ground, must_keep_up: bool) -> bool:
        """Whether its decisions need no further look there: it kept up, or need not."""
        if (kept_as, ground, True) in self._timed_on:
            return True
        return not must_keep_up and (kept_as, ground, False) in self._timed_on

    def _spares(self, kept_as: _Kept) -> list[Agent]:
        """Reusable agents; those of an older checkpoint of the same id are dropped."""
        for other in [other for other in self._spare if other[0] == kept_as[0] and other != kept_as]:
            del self._spare[other]
        return self._spare.get(kept_as, [])

    def _keep_spare(self, seat: _Seat) -> None:
        """Keep an agent for a later seat; agents with other options are other agents, and not all can be kept."""
        kept = self._spare.pop(seat.kept_as, [])
        self._spare[seat.kept_as] = [*kept, seat.agent]  # as the newest
        if sum(len(agents) for agents in self._spare.values()) > MOST_SPARE or len(self._spare) > MOST_SPARE_IDS:
            oldest = next(iter(self._spare))
            self._spare[oldest].pop()
            if not self._spare[oldest] or len(self._spare) > MOST_SPARE_IDS:
                del self._spare[oldest]

    def _decide(self, seat: _Seat, question: Observe) -> FromWorker:
        begun = time.thread_time()
        try:
            with self._budget.deciding(seat.agent):
                chunk = checked_chunk(seat.agent.act(_seen(seat, question)))
            return _answer(seat, question, chunk, time.thread_time() - begun)
        except FOREIGN_CODE_RAISES as error:  # the boundary around an agent; Ctrl-C does not reach this process
            return self._failed(seat, question, error)

    def _decide_together(self, asked: list[Observe]) -> list[FromWorker] | None:
        """All answers from one call; None when it fails, so that each agent is asked alone and the faulty one is found.

        A failed call may have advanced the agents' memory and random numbers: their answers are then valid, but not
        bit-equal to those they would have given alone.
        """
        begun = time.thread_time()
        seats = [self._seats[question.key] for question in asked]
        first = seats[0].agent
        assert isinstance(first, BatchAgent)
        try:
            observations = [_seen(seat, question) for seat, question in zip(seats, asked, strict=True)]
            agents = [seat.agent for seat in seats]
            with self._budget.deciding(*agents):
                given = first.act_many(agents, observations)
            chunks = [checked_chunk(chunk) for chunk in given]
            each_s = (time.thread_time() - begun) / len(asked)
            return [
                _answer(seat, question, chunk, each_s)
                for seat, question, chunk in zip(seats, asked, chunks, strict=True)
            ]
        except FOREIGN_CODE_RAISES:  # the boundary around an agent
            return None

    def _failed(self, seat: _Seat, question: Observe, error: BaseException) -> Failed:
        seat.failures += 1
        fatal = seat.failures >= GIVE_UP_AFTER
        try:
            seat.agent.reset(seat.episode)  # what it remembers may be the cause
        except FOREIGN_CODE_RAISES:  # the boundary around an agent
            fatal = True
        if fatal:
            del self._seats[question.key]
        return Failed(question.key, question.tick, _sentence(error), fatal)


def _seen(seat: _Seat, question: Observe) -> Observation:
    return observe(seat.episode.map, observed_state(question), seat.episode.seat, question.tick, question.pings)


def _answer(seat: _Seat, question: Observe, chunk: ActionChunk, spent_s: float) -> FromWorker:
    """The message with a checked chunk, which took `spent_s` of the processor."""
    execute, detail = rows_to_execute(seat.agent, chunk), decision_trace(seat.agent)
    seat.failures = 0
    return answer_message(question.key, question.tick, chunk, execute, spent_s * 1e3, detail)


def _warm(agent: Agent, episode: EpisodeInfo) -> Agent:
    """Make the first, slow decision before anybody waits for it."""
    agent.reset(episode)
    agent.act(observe(episode.map, start_state(episode.map), episode.seat))
    return agent


def _ground(map_spec: MapSpec) -> _Ground:
    return ((), ()) if is_reserved(map_spec.name) else (map_spec.walls, map_spec.goals)


def _timed(agent_id: str, agent: Agent, episode: EpisodeInfo, must_keep_up: bool) -> tuple[float, bool]:
    """The share of a core that deciding takes: the median of a few first decisions, each of a fresh episode.

    And whether it keeps up. Raises TooSlowError where it must and even the fastest takes longer than a tick: all would
    come too late.
    """
    times, chunk = first_decisions(agent, episode, time.thread_time)
    keeps_up = min(times) <= TICK_SECONDS
    if must_keep_up and not keeps_up:
        raise TooSlowError(
            f"{agent_id} needs {1e3 * min(times):.0f} ms for a decision on this machine and on this map, and a tick "
            f"has {1e3 * TICK_SECONDS:.0f} ms: here it is for matches without people; a server that is started with "
            "--slow-agents lets it play and miss ticks"
        )
    return statistics.median(times) / (TICK_SECONDS * rows_to_execute(agent, checked_chunk(chunk))), keeps_up


def _sentence(error: BaseException) -> str:
    text = str(error).strip()
    if isinstance(error, AgentError) and text:
        return writable(text)
    return located(f"{type(error).__name__}: {text}" if text else type(error).__name__, error)


def serve(link: socket.socket, heartbeat: WorkerHeartbeat, budget: ThreadBudget) -> None:
    """Answer until the other end closes the socket, or an agent's threads compute too much."""
    queue = DecisionQueue(heartbeat, budget)
    buffer = FrameBuffer()
    while True:
        if (overrun := queue.overrun()) is not None:
            link.sendall(frame(overrun))
            os._exit(OVERRUN)  # an ordinary end would wait for the threads
        heartbeat.write("idle")
        readable, _, _ = select.select([link], [], [], 0.0 if queue.busy else IDLE_WAIT_S)
        if readable:
            data = link.recv(1 << 16)
            if not data:
                return
            for body in buffer.feed(data):
                reply = queue.take(read_to_worker(body))
                if reply is not None:
                    link.sendall(frame(reply))
        elif queue.busy:
            for answer in queue.answer_next(time.monotonic()):
                link.sendall(frame(answer))


def main(arguments: list[str]) -> None:
    """Serve on the inherited descriptors."""
    for number in (
        signal.SIGINT,
        signal.SIGTERM,
        signal.SIGUSR1,
    ):  # the server's affair: it closes the socket, or kills
        signal.signal(number, signal.SIG_IGN)
    os.dup2(2, 1)  # an agent that prints must not disturb the server's standard output
    os.nice(10)  # people's ticks come first
    limit_memory()
    end_with_parent()
    with socket.socket(fileno=int(arguments[0])) as link:
        try:
            serve(link, WorkerHeartbeat(int(arguments[1])), ThreadBudget(float(arguments[2])))
        except (ConnectionResetError, BrokenPipeError):
            return  # the server is gone


def limit_memory(most: int = MOST_MEMORY) -> None:
    """An agent that asks for more fails, instead of the machine: a network may compute the size of what it makes."""
    _, hard = resource.getrlimit(resource.RLIMIT_DATA)
    most = most if hard == resource.RLIM_INFINITY else min(most, hard)
    with contextlib.suppress(ValueError, OSError):  # a system other than Linux may refuse this limit
        resource.setrlimit(resource.RLIMIT_DATA, (most, hard))
