"""The actions of one tick: inputs frozen for people and programs, answers looked up for agents."""

from movingout.recordings import AgentDecision
from movingout.server.rooms.input_buffer import Latch
from movingout.server.rooms.round import Round
from movingout.server.rooms.seat import AgentPlayer, Seat


def latch(the_round: Round, seat: Seat, now: float) -> Latch:
    """What `seat` does in the tick that starts now; never waits."""
    if seat.player is None:
        return seat.latch(now)
    return _answer(the_round, seat.index, seat.player)


def ask_agents(the_round: Round, seats: list[Seat], deadline: float) -> None:
    """Hand the state to the agents; their answer is wanted at `deadline` (when the next tick starts)."""
    for seat in seats:
        if seat.player is not None:
            seat.player.observe(the_round.state, the_round.state.tick, deadline)


def _answer(the_round: Round, seat: int, player: AgentPlayer) -> Latch:
    answer = player.answer(the_round.state.tick)
    if answer.missed or answer.latency_ms >= 0:
        tick = the_round.state.tick + 1
        the_round.recorder.agent(AgentDecision(tick, seat, answer.latency_ms, answer.missed, answer.detail))
    if answer.missed:
        the_round.deadline_misses += 1
        the_round.note("deadline_missed", seat)
    if answer.problem:
        the_round.note("agent_error", seat, detail=answer.problem)
    return Latch(answer.action, -1, -1.0, not answer.missed)
