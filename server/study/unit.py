"""Who plays together: one participant with agents, or two with each other; and the room they are in."""

from dataclasses import dataclass, field

from movingout.server.rooms.room import Room
from movingout.server.study.participant_session import ParticipantSession
from movingout.study.design.steps import Step
from movingout.study.store import Unit
from movingout.study.store.rounds import PlayerOutcome, RoundOutcome

FINISHED = ("delivered", "time")  # outcomes of rounds that count


@dataclass(frozen=True, slots=True)
class RunningRound:
    """A round or the practice in its room."""

    room: Room
    step: Step
    keys: dict[str, str]  # pid to the key of the seat
    seats: dict[str, int]  # pid to seat


@dataclass(frozen=True, slots=True)
class FinishedRound:
    """A round or the practice that has ended, until the store knows of it."""

    step: Step
    episode: str
    outcome: RoundOutcome
    players: tuple[PlayerOutcome, ...]

    @property
    def counts(self) -> bool:
        return self.outcome.outcome in FINISHED


@dataclass(eq=False)
class StudyUnit:
    """A unit of the study."""

    record: Unit
    members: list[ParticipantSession]
    ready: set[str] = field(default_factory=set)  # pids who want the round of their step to begin
    ready_at: float = 0.0  # when the first of them said so
    running_round: RunningRound | None = None
    finished_round: FinishedRound | None = None
    paused: bool = False
    problem: str = ""  # why no round can begin now
    episode: str = ""  # the recording of the newest round

    def others(self, session: ParticipantSession) -> list[ParticipantSession]:
        return [other for other in self.members if other is not session]

    def at(self, step: Step) -> list[ParticipantSession]:
        """Who is at this step."""
        return [one for one in self.members if one.record.step == step.key]

    def all_ready(self, step: Step) -> bool:
        """Whether everybody wants it to begin; a round needs all, practice those who have not had enough of it."""
        here = self.at(step)
        if step.kind == "practice":  # somebody may be on the way: a kill came between the moves of the two
            everybody = not any(one.before_unit_steps for one in self.members)
        else:
            everybody = len(here) == len(self.members)
        return everybody and all(one.pid in self.ready for one in here)

    def seat_of(self, step: Step, session: ParticipantSession) -> int:
        """0 blue, 1 red: the second of a pair sits opposite the first."""
        first = step.turn.seat if step.turn else 0
        return (first + self.members.index(session)) % 2
