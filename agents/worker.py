"""The process in which agents think: one thread, earliest deadline first, no knowledge of rooms or browsers.

Started by `server.agent_process` as `python -m agents.worker SOCKET_FD BOARD_FD`; ends when the socket closes.
"""

import os
import select
import signal
import socket
import sys
import threading
import time
from dataclasses import dataclass

from agents.base import Agent, EpisodeInfo
from agents.blackboard import Blackboard
from agents.catalogue import load_agent
from agents.chunk import checked_chunk, rows_to_execute
from agents.observing import observe, said, start_state
from agents.worker_messages import (
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

IDLE_WAIT_S = 0.5  # how often an idle worker says that it lives
GIVE_UP_AFTER = 20  # failures in a row after which a seat is not asked again


@dataclass(slots=True)
class _Seat:
    agent: Agent
    agent_id: str
    episode: EpisodeInfo
    failures: int = 0


class Desk:
    """The seats of one worker and their open questions; knows no socket."""

    def __init__(self, board: Blackboard) -> None:
        self._board = board
        self._seats: dict[int, _Seat] = {}
        self._questions: dict[int, Observe] = {}
        self._spare: dict[str, list[Agent]] = {}

    @property
    def busy(self) -> bool:
        """Whether a question waits."""
        return bool(self._questions)

    def take(self, message: ToWorker) -> FromWorker | None:
        """Note a message; opening a seat loads its agent at once."""
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
                    self._spare.setdefault(seat.agent_id, []).append(seat.agent)
        return None

    def answer_next(self, now: float) -> FromWorker:
        """Answer the question with the earliest deadline (there is one: see `busy`)."""
        question = min(self._questions.values(), key=lambda waiting: waiting.deadline)
        del self._questions[question.key]
        if now > question.deadline:
            return Skipped(question.key, question.tick)
        self._board.write("deciding", question.key)
        return self._decide(self._seats[question.key], question)

    def _open(self, message: Open) -> FromWorker:
        self._board.write("loading", message.key)
        episode = EpisodeInfo(message.map, message.seat, message.seed, message.ticks)
        try:
            spare = self._spare.get(message.agent_id)
            agent = spare.pop() if spare else _warm(load_agent(message.agent_id), episode)
            agent.reset(episode)
        except Exception as error:  # noqa: BLE001 - the boundary around an agent
            return Failed(message.key, -1, _sentence(error), fatal=True)
        self._seats[message.key] = _Seat(agent, message.agent_id, episode)
        return Opened(message.key)

    def _decide(self, seat: _Seat, question: Observe) -> FromWorker:
        begun = time.perf_counter()
        try:
            observation = observe(seat.episode.map, observed_state(question), seat.episode.seat, question.tick)
            chunk = checked_chunk(seat.agent.act(observation))
            execute = rows_to_execute(seat.agent, chunk)
            detail = said(seat.agent)
        except Exception as error:  # noqa: BLE001 - the boundary around an agent
            return self._failed(seat, question, error)
        seat.failures = 0
        return answer_message(question.key, question.tick, chunk, execute, (time.perf_counter() - begun) * 1e3, detail)

    def _failed(self, seat: _Seat, question: Observe, error: Exception) -> Failed:
        seat.failures += 1
        fatal = seat.failures >= GIVE_UP_AFTER
        try:
            seat.agent.reset(seat.episode)  # what it remembers may be the cause
        except Exception:  # noqa: BLE001 - the boundary around an agent
            fatal = True
        if fatal:
            del self._seats[question.key]
        return Failed(question.key, question.tick, _sentence(error), fatal)


def _warm(agent: Agent, episode: EpisodeInfo) -> Agent:
    """Let the first, slow decision happen before anybody waits for it."""
    agent.reset(episode)
    agent.act(observe(episode.map, start_state(episode.map), episode.seat))
    return agent


def _sentence(error: Exception) -> str:
    text = str(error).strip()
    return f"{type(error).__name__}: {text}"[:500] if text else type(error).__name__


def serve(link: socket.socket, board: Blackboard) -> None:
    """Answer until the other end closes the socket."""
    desk = Desk(board)
    buffer = FrameBuffer()
    while True:
        board.write("idle")
        readable, _, _ = select.select([link], [], [], 0.0 if desk.busy else IDLE_WAIT_S)
        if readable:
            data = link.recv(1 << 16)
            if not data:
                return
            for body in buffer.feed(data):
                reply = desk.take(read_to_worker(body))
                if reply is not None:
                    link.sendall(frame(reply))
        elif desk.busy:
            link.sendall(frame(desk.answer_next(time.monotonic())))


def main(arguments: list[str]) -> None:
    """Serve on the inherited descriptors."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the server's affair; it closes the socket
    os.dup2(2, 1)  # an agent that prints must not disturb the server's standard output
    os.nice(5)
    threading.Thread(target=_end_with_parent, args=(os.getppid(),), daemon=True).start()
    with socket.socket(fileno=int(arguments[0])) as link:
        try:
            serve(link, Blackboard(int(arguments[1])))
        except (ConnectionResetError, BrokenPipeError):
            return  # the server is gone


def _end_with_parent(parent: int) -> None:
    """A worker that hangs does not notice a closed socket: nobody may outlive the server."""
    while os.getppid() == parent:
        time.sleep(1.0)
    os._exit(0)


if __name__ == "__main__":
    main(sys.argv[1:])
