"""The phases of a room as a table: what may happen in each, and which phase follows.

lobby -> countdown -> playing <-> paused -> round_over -> countdown ... -> series_over;   closed ends it all
"""

from enum import Enum
from typing import Literal, get_args

from movingout.maps.errors import MovingOutError
from movingout.server.messages import Phase


class PhaseError(MovingOutError):
    """An event in a phase in which it cannot happen: a bug of the server."""


class PhaseEvent(Enum):
    """What moves a room from one phase to another."""

    ALL_READY = "everybody is ready"
    START = "the countdown is over"
    CALLED_OFF = "a countdown is called off before the round, or a seat is free again"
    INTERRUPTED = "somebody is absent or not ready in a round, or the clock is held"
    ROUND_ENDED = "the round is over and another one follows"
    SERIES_ENDED = "nothing more is played"
    CLOSED = "the room closes"


Request = Literal["ready", "again", "pause", "ping", "leave", "skip"]

IN_ROUND: frozenset[Phase] = frozenset({"countdown", "playing", "paused"})
BETWEEN_ROUNDS: frozenset[Phase] = frozenset({"round_over", "series_over"})
PHASES: frozenset[Phase] = frozenset(get_args(Phase))
OPEN = PHASES - {"closed"}

# What a person in a seat may ask for, and when.
ALLOWED: dict[Request, frozenset[Phase]] = {
    "ready": frozenset({"lobby", "countdown", "paused", "round_over"}),
    "again": BETWEEN_ROUNDS,
    "pause": frozenset({"playing"}),
    "skip": frozenset({"playing", "paused"}),
    "ping": frozenset({"playing"}),
    "leave": OPEN,
}

_EVENTS: dict[PhaseEvent, tuple[frozenset[Phase], Phase]] = {
    PhaseEvent.ALL_READY: (OPEN - {"countdown", "playing"}, "countdown"),
    PhaseEvent.START: (frozenset({"countdown"}), "playing"),
    PhaseEvent.CALLED_OFF: (frozenset({"lobby", "countdown"}), "lobby"),
    PhaseEvent.INTERRUPTED: (frozenset({"lobby", *IN_ROUND}), "paused"),  # lobby: a round goes on after a restart
    PhaseEvent.ROUND_ENDED: (IN_ROUND, "round_over"),
    PhaseEvent.SERIES_ENDED: (OPEN, "series_over"),
    PhaseEvent.CLOSED: (PHASES, "closed"),
}
TRANSITIONS: dict[tuple[Phase, PhaseEvent], Phase] = {
    (before, event): after for event, (phases, after) in _EVENTS.items() for before in phases
}


def next_phase(phase: Phase, event: PhaseEvent) -> Phase:
    """Raises PhaseError with the phases in which the event is possible."""
    after = TRANSITIONS.get((phase, event))
    if after is None:
        raise PhaseError(f"{event.value}: possible in {names(_EVENTS[event][0])}; the room is in {phase}")
    return after


def possible(phase: Phase, event: PhaseEvent) -> bool:
    return (phase, event) in TRANSITIONS


def names(phases: frozenset[Phase]) -> str:
    """In the order in which a room goes through them."""
    return ", ".join(phase for phase in get_args(Phase) if phase in phases)
