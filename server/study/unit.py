"""A unit: one participant who plays with agents, or two who play with each other; and their rounds."""

from dataclasses import dataclass, field

from movingout.recordings.episode import FINISHED
from movingout.server.rooms.room_view import RoomView
from movingout.server.study.participant_session import ParticipantSession
from movingout.study.design.steps import Step
from movingout.study.store import Unit
from movingout.study.store.rounds import PlayerOutcome, RoundOutcome


@dataclass(slots=True)
class RunningRound:
    """A round or the practice in its room, which may be in another process."""

    view: RoomView  # at most about a second old
    step: Step
    keys: dict[str, str]  # of the seats, by pid
    seats: dict[str, int]  # by pid
    lost_since: float | None = None  # when its room was found gone, in seconds of the monotonic clock

    @property
    def room(self) -> str:
        """The id of the room."""
        return self.view.id

    @property
    def is_lost(self) -> bool:
        return self.lost_since is not None


@dataclass(frozen=True, slots=True)
class FinishedRound:
    """A round or the practice that has ended and is not saved yet."""

    step: Step
    episode: str
    outcome: RoundOutcome
    players: tuple[PlayerOutcome, ...]

    @property
    def counts(self) -> bool:
        return self.outcome.outcome in FINISHED


@dataclass(eq=False)
class StudyUnit:
    """A unit that is taking part; `record` is its row in the database. Changed only by the holder of a transaction."""

    record: Unit
    members: list[ParticipantSession]
    size: int  # how many began, also those who were removed from the data since
    ready: set[str] = field(default_factory=set)  # pids of those who want the round of their step to begin
    ready_at: float = 0.0  # when the first of them was, in seconds of the monotonic clock
    slow_told: bool = False  # whether the experimenter knows that they wait for a partner who is here
    running_round: RunningRound | None = None
    finished_round: FinishedRound | None = None
    paused_by_hand: bool = False  # somebody pressed "Pause"; kept in the database
    holds: set[str] = field(default_factory=set)  # of dialogs that are open, for whose time the unit is paused, too
    standing_since: float | None = None  # when a pause began that is still on, in seconds of the monotonic clock
    problem: str = ""  # why no round can begin now
    episode: str = ""  # the recording of the newest round
    blocks_over: frozenset[str] = frozenset()  # whose time was up when it was last looked
    finished_steps: frozenset[str] = frozenset()  # the rounds that were played by then
    left_out: frozenset[str] = frozenset()  # the rounds that cannot be played

    @property
    def paused(self) -> bool:
        return self.paused_by_hand or bool(self.holds)

    def set_paused(self, paused: bool, hold: str | None = None) -> None:
        """Pause, or resume whatever paused the unit; begin or end one hold alone."""
        if hold is None:
            self.paused_by_hand = paused
            self.holds = self.holds if paused else set()
        elif paused:
            self.holds.add(hold)
        else:
            self.holds.discard(hold)

    @property
    def finished(self) -> bool:
        """Whether all members have their codes and every round is saved."""
        return self.running_round is None and self.finished_round is None and all(one.finished for one in self.members)

    @property
    def lacks_member(self) -> bool:
        """Whether one of a pair was removed from the data: the other one's partner is no agent."""
        return len(self.members) < self.size

    def others(self, session: ParticipantSession) -> list[ParticipantSession]:
        return [other for other in self.members if other is not session]

    def members_at(self, step: Step) -> list[ParticipantSession]:
        """Who is at this step."""
        return [one for one in self.members if one.record.step == step.key]

    def plays(self, step: Step) -> bool:
        """Whether the round of this step is being played, or saved."""
        running, finished = self.running_round, self.finished_round
        return step.key in (running and running.step.key, finished and finished.step.key)

    def note_standing(self, stands: bool, now: float) -> None:
        """Whether play stands still, by the experimenter or a player; a pause is no time at a step."""
        if stands:
            self.standing_since = now if self.standing_since is None else self.standing_since
        elif self.standing_since is not None:
            for session in self.members:
                session.step_since += now - max(self.standing_since, session.step_since)
            self.standing_since = None

    def set_ready(self, session: ParticipantSession, now: float) -> None:
        """The participant wants the round of their step to begin."""
        if not self.ready:
            self.ready_at, self.slow_told = now, False
        self.ready.add(session.pid)

    def all_ready(self, step: Step) -> bool:
        """Whether the round can begin: everybody is ready, in practice everybody who has not finished practising."""
        here = self.members_at(step)
        if step.kind == "practice":  # a kill may have come between the moves of the two
            everybody = not any(one.before_unit_steps for one in self.members)
        else:
            everybody = len(here) == len(self.members)
        return everybody and all(one.pid in self.ready for one in here)

    def seat_of(self, step: Step, session: ParticipantSession) -> int:
        """0 blue, 1 red: the second of a pair sits opposite the first."""
        first = step.turn.seat if step.turn else 0
        return (first + self.members.index(session)) % 2
