"""The table of a room's phases: complete, and strict about what cannot happen."""

from typing import get_args

import pytest

from movingout.server.messages import Phase
from movingout.server.rooms.phases import ALLOWED, TRANSITIONS, PhaseError, PhaseEvent, next_phase, possible


def test_a_whole_series_with_a_pause_goes_through_the_table() -> None:
    phase: Phase = "lobby"
    seen = []
    ready, start = PhaseEvent.ALL_READY, PhaseEvent.START
    first = [ready, start, PhaseEvent.INTERRUPTED, ready, start, PhaseEvent.ROUND_ENDED]
    second = [ready, start, PhaseEvent.SERIES_ENDED, PhaseEvent.CLOSED]
    for event in first + second:
        phase = next_phase(phase, event)
        seen.append(phase)
    assert " ".join(seen) == (
        "countdown playing paused countdown playing round_over countdown playing series_over closed"
    )


def test_what_cannot_happen_is_refused_with_what_was_expected() -> None:
    with pytest.raises(PhaseError, match="the countdown is over: possible in countdown; the room is in lobby"):
        next_phase("lobby", PhaseEvent.START)
    with pytest.raises(PhaseError, match="possible in countdown, playing, paused; the room is in round_over"):
        next_phase("round_over", PhaseEvent.ROUND_ENDED)


def test_every_phase_can_be_reached_and_every_phase_can_close() -> None:
    assert {"lobby", *TRANSITIONS.values()} == set(get_args(Phase))
    assert all(possible(phase, PhaseEvent.CLOSED) for phase in get_args(Phase))
    assert {event for phase, event in TRANSITIONS if phase == "closed"} == {PhaseEvent.CLOSED}


def test_a_closed_room_grants_no_request() -> None:
    assert not any("closed" in phases for phases in ALLOWED.values())
