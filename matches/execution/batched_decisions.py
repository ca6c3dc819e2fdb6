"""Asking many seats for their next rows: agents of one kind in one batch, all answers checked and converted at once."""

from collections import defaultdict
from collections.abc import Hashable, Sequence

import numpy as np

from movingout.agents.action_chunk import checked_chunk
from movingout.agents.base import BatchAgent
from movingout.agents.errors import AgentError
from movingout.matches.execution.decision_timeout import Stopwatch, TooLate
from movingout.matches.execution.seat import AgentFault, Blaming, Seat, sentence
from movingout.world.action import to_world
from movingout.world.state import Floats

Answer = tuple[Seat, object]
Chunks = list[tuple[Seat, Floats]]

_FLOAT64 = np.dtype(np.float64)


def ask(seats: Sequence[Seat], stopwatch: Stopwatch) -> None:
    """Give every seat rows to play, or a fault."""
    answers: list[Answer] = []
    groups: dict[Hashable, list[Seat]] = defaultdict(list)
    for seat in seats:
        if seat.group is None:
            _ask_one(seat, answers, stopwatch)
        else:
            groups[seat.group].append(seat)
    for group in groups.values():
        _ask_together(group, answers, stopwatch)
    if not _hand_out_single_rows(answers):
        _hand_out(_checked_chunks(answers, stopwatch))


def _ask_one(seat: Seat, answers: list[Answer], stopwatch: Stopwatch) -> None:
    """As with `Blaming`, written out: this is the innermost loop of every match."""
    stopwatch.start()
    try:
        answers.append((seat, seat.agent.act(seat.observation())))
    except (TooLate, Exception, SystemExit) as error:  # noqa: BLE001  # anybody's code is behind it
        call = f"act() at tick {seat.state.tick}"
        seat.lose(sentence(seat.episode.seat, seat.agent_id, call, error, stopwatch.limit_s))
    finally:
        stopwatch.stop()


def _ask_together(group: list[Seat], answers: list[Answer], stopwatch: Stopwatch) -> None:
    """One call for a whole group; one that fails as a whole is lost as a whole."""
    agents, first = [seat.agent for seat in group], group[0]
    assert isinstance(first.agent, BatchAgent)
    try:
        with Blaming(first.episode.seat, first.agent_id, stopwatch, "act_many()"):
            given = list(first.agent.act_many(agents, [seat.observation() for seat in group]))
            if len(given) != len(group):
                raise AgentError(f"{len(given)} chunks for {len(group)} observations")
    except AgentFault as fault:
        for seat in group:
            seat.lose(fault.reason)
        return
    answers += zip(group, given, strict=True)


def _hand_out_single_rows(answers: list[Answer]) -> bool:
    """The quick way when every answer is one sound row (1, 4); False, and nothing done, when one is not."""
    if not answers or not all(_is_single_row(given) for _, given in answers):
        return False
    table: Floats = np.concatenate([given for _, given in answers])
    if not _sound(table):
        return False
    rows: list[list[float]] = to_world(table).tolist()
    for (seat, _), row in zip(answers, rows, strict=True):
        seat.rows = [row]
    return True


def _checked_chunks(answers: list[Answer], stopwatch: Stopwatch) -> Chunks:
    """The answers that are chunks, each examined alone; the others lose their seat."""
    chunks: Chunks = []
    for seat, given in answers:
        try:
            with Blaming(seat.episode.seat, seat.agent_id, stopwatch, f"its answer at tick {seat.state.tick}"):
                chunks.append((seat, checked_chunk(given)))
        except AgentFault as fault:
            seat.lose(fault.reason)
    return chunks


def _hand_out(chunks: Chunks) -> None:
    if not chunks:
        return
    rows: list[list[float]] = to_world(np.concatenate([chunk for _, chunk in chunks])).tolist()
    start = 0
    for seat, chunk in chunks:
        seat.take(chunk, rows[start : start + len(chunk)])
        start += len(chunk)


def _is_single_row(given: object) -> bool:
    return type(given) is np.ndarray and given.dtype == _FLOAT64 and given.shape == (1, 4)


def _sound(rows: Floats) -> bool:
    """Whether chunk rows (n, 4) need no closer look; `to_world` clips and rounds them."""
    return bool(np.isfinite(rows).all() and (np.abs(rows[:, 1]) + np.abs(rows[:, 2]) > 1e-5).all())
