"""Failure cases per session, as the paper counted them: a session is one participant with one partner in one seat.

The paper gives shares of 64 sessions, 32 participants in both seats ("Failure case study (RQ5)").
"""

from collections import defaultdict
from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from movingout.matches.paper.published import Figure, published_tables
from movingout.recordings.annotation.agreement import settled
from movingout.recordings.annotation.finding import Finding, SearchedRecording
from movingout.recordings.annotation.search import search_failures
from movingout.recordings.annotation.verdicts import Verdicts, annotations
from movingout.recordings.errors import RecordingError
from movingout.recordings.report.failures import Case
from movingout.study.errors import StudyError

PAPER_SESSIONS = 64
_COLUMNS: Mapping[str, Case] = {"no_handover": "keeps", "no_help": "stays_away", "no_grasp": "no_grasp"}
PAPER_FAILURES: Mapping[str, Mapping[Case, Figure]] = {  # shares of 64 sessions
    row.name: {_COLUMNS[column.measure]: one for column, one in row.figures.items()}
    for row in published_tables()["fig:failure_cases"].rows
}
_PAPER_LABELS = {"dp": "DP", "bass": "DP/BASS"}


def paper_label(agent: str) -> str:
    """The row of the paper's human study that an agent stands beside, "" for none: `bass@all:lag=1` is DP/BASS."""
    return _PAPER_LABELS.get(agent.partition(":")[0].partition("@")[0], "")


@dataclass(slots=True)
class Session:
    """The rounds of one participant with one partner in one seat, in blocks that are pooled."""

    unit: int
    partner: str
    seat: int  # of the partner
    block: str  # the first of those that are pooled with that of the rounds
    findings: list[Finding] = field(default_factory=list)  # where the partner failed

    def has(self, case: Case) -> bool:
        """Whether the rules found it."""
        return any(one.case == case for one in self.findings)

    def confirmed(self, case: Case, verdicts: Verdicts) -> bool:
        """Whether more annotators confirm than reject one of the findings."""
        return any(settled(verdicts.get(one.id, {}).values()) is True for one in self.findings if one.case == case)


@dataclass(frozen=True, slots=True)
class Sessions:
    """All sessions of a study whose rounds have recordings."""

    sessions: tuple[Session, ...] = ()
    recordings: tuple[SearchedRecording, ...] = ()  # of the rounds that count
    verdicts: Verdicts = field(default_factory=dict)

    def of_blocks(self, blocks: Container[str]) -> "Sessions":
        """Those of blocks that are pooled."""
        return replace(self, sessions=tuple(one for one in self.sessions if one.block in blocks))

    @property
    def findings(self) -> list[Finding]:
        """Where partners failed, not participants."""
        return [finding for session in self.sessions for finding in session.findings]

    def official(self, metric: str) -> dict[str, float]:
        """By episode that has it, what the official code counts: `waiting_share` or `official_ac`."""
        values = {one.id: getattr(one, metric) for one in self.recordings}
        return {episode: value for episode, value in values.items() if value is not None}


def sessions_of(
    rounds: Sequence[dict[str, Any]],
    players: Iterable[dict[str, Any]],
    folder: Path,
    files: Sequence[Path],
    pooled: Iterable[Sequence[str]],
) -> Sessions:
    """The sessions of rounds with an agent; `files` are further annotations, `pooled` groups of blocks.

    Raises StudyError for annotations of other recordings.
    """
    with_agent = {row["episode"]: row for row in rounds if row["partner"]}
    if not with_agent or not folder.is_dir():
        return Sessions()
    try:
        found = tuple(one for one in search_failures(folder).recordings if one.id in with_agent)
        verdicts = annotations(folder, files, found)
    except RecordingError as error:
        raise StudyError(str(error)) from error
    seated = {one["round"]: one["seat"] for one in players}
    first = {block: blocks[0] for blocks in pooled for block in blocks}
    sessions: dict[tuple[int, str, int, str], Session] = {}
    for recording in found:
        row = with_agent[recording.id]
        if row["id"] not in seated:
            continue
        key = (row["unit"], row["partner"], 1 - seated[row["id"]], first[row["block"]])
        session = sessions.setdefault(key, Session(*key))
        session.findings += [one for one in recording.findings if one.seat == session.seat]
    return Sessions(tuple(sessions.values()), found, verdicts)


def by_partner(sessions: Iterable[Session]) -> dict[str, list[Session]]:
    found: defaultdict[str, list[Session]] = defaultdict(list)
    for session in sessions:
        found[session.partner].append(session)
    return dict(found)
