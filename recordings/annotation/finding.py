"""A failure case that the rules found in a recording, and what a person says about it."""

from dataclasses import dataclass
from typing import Any, Literal, get_args

from movingout.recordings.episode import player_label
from movingout.recordings.report.failures import CASES, Case, Failure
from movingout.recordings.report.words import Words

Verdict = Literal["confirmed", "rejected", "unsure"]
VERDICTS: tuple[Verdict, ...] = get_args(Verdict)
_ENGLISH = Words()


@dataclass(frozen=True, slots=True)
class Finding:
    """One failure case in one recording."""

    recording: str  # episode id
    case: Case
    seat: int  # who failed
    item: int  # index
    start: int  # first tick
    end: int  # first tick after
    detail: str  # in English

    @property
    def id(self) -> str:
        """The same for the same finding, whoever searches for it; another one when the rules place it elsewhere."""
        return f"{self.recording}:{self.case}:{self.seat}:{self.item}:{self.start}"

    @classmethod
    def of(cls, recording: str, failure: Failure) -> "Finding":
        detail = _ENGLISH.phrase(failure.detail)
        return cls(recording, failure.case, failure.seat, failure.item, failure.start, failure.end, detail)


@dataclass(frozen=True, slots=True)
class SearchedSeat:
    """Who sat in a seat of a searched recording."""

    kind: str  # human, agent, ...
    name: str


@dataclass(frozen=True, slots=True)
class SearchedRecording:
    """A finished recording in which failure cases were looked for."""

    id: str
    map: str
    study: str  # id of the study, "" for none
    seats: tuple[SearchedSeat, SearchedSeat]
    findings: tuple[Finding, ...]
    waiting_share: float = 0.0  # of the ticks, as the official code counts waiting
    official_ac: float | None = None  # as the official code counts; None where nothing was carried together
    played: str = ""  # what copies of the episode share, as agents without chance play it again
    simulated: bool = False  # in a rehearsal of a study: its participants were programs
    agent_errors: tuple[str, ...] = ()  # the faults that its agents had, in English

    def who(self, seat: int) -> str:
        """The player of a seat: all people as one, agents by id without options."""
        return player_label(self.seats[seat].kind, self.seats[seat].name, self.simulated)

    def to_json(self) -> dict[str, Any]:
        return {
            "id": self.id,
            "map": self.map,
            "study": self.study,
            "seats": [[seat.kind, seat.name] for seat in self.seats],
            "waiting_share": self.waiting_share,
            "official_ac": self.official_ac,
            "played": self.played,
            "simulated": self.simulated,
            "agent_errors": list(self.agent_errors),
            "findings": [[one.case, one.seat, one.item, one.start, one.end, one.detail] for one in self.findings],
        }

    @classmethod
    def from_json(cls, document: dict[str, Any]) -> "SearchedRecording":
        blue, red = (SearchedSeat(*seat) for seat in document["seats"])
        findings = tuple(Finding(document["id"], *one) for one in document["findings"])
        return cls(
            document["id"], document["map"], document["study"], (blue, red), findings,
            waiting_share=document["waiting_share"], official_ac=document["official_ac"], played=document["played"],
            simulated=document["simulated"], agent_errors=tuple(document["agent_errors"]),
        )  # fmt: skip


def case_of(finding: str) -> Case:
    """The case that the id of a finding names. Raises ValueError."""
    named = finding.split(":")[1:2]
    for case in CASES:
        if named == [case]:
            return case
    raise ValueError(f"{finding!r} is not the id of a finding")
