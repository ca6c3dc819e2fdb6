"""Decisions of many seats at once: agents of one group in one batch, all chunks checked and converted together."""

from collections import defaultdict
from collections.abc import Hashable, Sequence

import numpy as np

from movingout.agents.action_chunk import checked_chunk, rows_to_execute
from movingout.agents.base import BatchAgent
from movingout.agents.errors import AgentError
from movingout.maps.files.ctrl_c import FOREIGN_CODE_RAISES, is_ctrl_c
from movingout.matches.execution.decision_timeout import DecisionTimeout, DecisionTimer
from movingout.matches.execution.seat import AgentFault, MatchSeat, attribute_agent_errors, fault_sentence
from movingout.world.action import to_world
from movingout.world.state import Floats

Answer = tuple[MatchSeat, object]
Chunks = list[tuple[MatchSeat, Floats]]

_FLOAT64 = np.dtype(np.float64)


def decide(seats: Sequence[MatchSeat], timer: DecisionTimer) -> None:
    """Get every seat its next rows to play, or a fault."""
    answers: list[Answer] = []
    groups: dict[Hashable, list[MatchSeat]] = defaultdict(list)
    for seat in seats:
        if seat.group is None:
            _decide_alone(seat, answers, timer)
        else:
            groups[seat.group].append(seat)
    for group in groups.values():
        _decide_together(group, answers, timer)
    if not _take_single_rows(answers):
        _take_chunks(_checked_chunks(answers, timer))


def _decide_alone(seat: MatchSeat, answers: list[Answer], timer: DecisionTimer) -> None:
    """`attribute_agent_errors` written out, as this is the innermost loop of every match."""
    timer.start()
    try:
        answers.append((seat, seat.agent.act(seat.observation())))
    except (DecisionTimeout, *FOREIGN_CODE_RAISES) as error:
        if is_ctrl_c(error):
            raise
        call = f"act() at tick {seat.state.tick}"
        seat.lose(fault_sentence(seat.episode.seat, seat.agent_id, call, error, timer.limit_s))
    finally:
        timer.stop()


def _decide_together(group: list[MatchSeat], answers: list[Answer], timer: DecisionTimer) -> None:
    """One call for a whole group; when it fails, every seat of the group has a fault."""
    agents, first = [seat.agent for seat in group], group[0]
    assert isinstance(first.agent, BatchAgent)
    try:
        with attribute_agent_errors(first.episode.seat, first.agent_id, timer, "act_many()"):
            given = list(first.agent.act_many(agents, [seat.observation() for seat in group]))
            if len(given) != len(group):
                raise AgentError(f"{len(given)} chunks for {len(group)} observations")
    except AgentFault as fault:
        for seat in group:
            seat.lose(fault.reason, together=len(group) > 1)
        return
    answers += zip(group, given, strict=True)


def _take_single_rows(answers: list[Answer]) -> bool:
    """A fast path for when every answer is one valid row (1, 4). Returns False when one is not."""
    if not answers or not all(_is_single_row(given) for _, given in answers):
        return False
    table: Floats = np.concatenate([given for _, given in answers])
    if not _are_valid(table):
        return False
    rows: list[list[float]] = to_world(table).tolist()
    for (seat, _), row in zip(answers, rows, strict=True):
        seat.rows = [row]
    return True


def _checked_chunks(answers: list[Answer], timer: DecisionTimer) -> Chunks:
    """The rows to play of the valid chunks among the answers, each checked alone; the other seats get a fault."""
    chunks: Chunks = []
    for seat, given in answers:
        try:
            with attribute_agent_errors(
                seat.episode.seat, seat.agent_id, timer, f"its answer at tick {seat.state.tick}"
            ):
                chunk = checked_chunk(given)
                chunks.append((seat, chunk[: rows_to_execute(seat.agent, chunk)]))
        except AgentFault as fault:
            seat.lose(fault.reason)
    return chunks


def _take_chunks(chunks: Chunks) -> None:
    if not chunks:
        return
    rows: list[list[float]] = to_world(np.concatenate([chunk for _, chunk in chunks])).tolist()
    start = 0
    for seat, chunk in chunks:
        seat.rows = rows[start : start + len(chunk)]
        start += len(chunk)


def _is_single_row(given: object) -> bool:
    return type(given) is np.ndarray and given.dtype == _FLOAT64 and given.shape == (1, 4)


def _are_valid(rows: Floats) -> bool:
    """Whether chunk rows (n, 4) need no further check; `to_world` clips and rounds them."""
    return bool(np.isfinite(rows).all() and (np.abs(rows[:, 1]) + np.abs(rows[:, 2]) > 1e-5).all())
