"""Checks that everything simulated participants did and were shown is in the study's data."""

from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from movingout.maps.suggestion import counted
from movingout.recordings.episode import FINISHED
from movingout.recordings.file_format.reader import read_episode
from movingout.recordings.storage.index import list_recordings
from movingout.server.study_bots.simulated_participant import ActivityLog
from movingout.study.data.study_folder import StudyFolder
from movingout.study.store.tables import answers, participants, rounds

Row = dict[str, Any]


@dataclass(frozen=True)
class StoredData:
    """The contents of the databases after a rehearsal."""

    pids: dict[str, str]  # pseudonyms by name
    participants: dict[str, Row]  # by pseudonym
    rounds: list[Row]
    answers: list[Row]


def read_stored(folder: StudyFolder) -> StoredData:
    with closing(folder.open_existing()) as store, closing(folder.open_identities()) as identities:
        return StoredData(
            {external: pid for pid, (_, external) in identities.everybody().items()},
            {row["pid"]: row for row in store.rows(participants)},
            store.rows(rounds),
            store.rows(answers),
        )


def find_losses(folder: StudyFolder, stored: StoredData, logs: Sequence[ActivityLog]) -> list[str]:
    """One sentence per difference between logs and data; empty when nothing was lost."""
    found = list(_doubled_rounds(stored)) + list(_recordings(folder, stored))
    for log in logs:
        found += [f"{log.name}: {sentence}" for sentence in _of_one(stored, log)]
    return found


def agent_faults(folder: StudyFolder, stored: StoredData) -> list[str]:
    """One sentence per fault that agents had, with the number of rounds. Raises RecordingError.

    Only the rounds of this study are looked at: the folder may hold recordings of others.
    """
    found, _ = list_recordings(folder.recordings) if folder.recordings.is_dir() else ([], [])
    played = {one["episode"] for one in stored.rounds if one["outcome"] in FINISHED}
    said = Counter(sentence for one in found if one.id in played for sentence in _agent_errors(one.path))
    return [f"in {counted(count, 'round')}: {sentence}" for sentence, count in said.items()]


def _agent_errors(recording: Path) -> set[str]:
    return {event.detail for event in read_episode(recording).events if event.kind == "agent_error"}


def _of_one(stored: StoredData, log: ActivityLog) -> Iterator[str]:
    row = stored.participants.get(stored.pids.get(log.name, ""))
    if row is None:
        yield "is not in the database"
        return
    if len(log.codes) != 1 or row["code"] not in log.codes:
        yield f"was shown the codes {sorted(log.codes)}; the database has {row['code']}"
    if row["outcome"] != log.outcome:
        yield f"ended with {log.outcome}; the database has {row['outcome']}"
    if log.deleted:
        if any(answer["pid"] == row["pid"] for answer in stored.answers):
            yield "asked for deletion, but answers are still there"
        return
    saved = {
        (one["step"], one["item"], one["value"], one["text"]) for one in stored.answers if one["pid"] == row["pid"]
    }
    yield from (f"the answer {click} is missing" for click in log.saved_answers if click not in saved)
    played = {one["step"] for one in stored.rounds if one["unit"] == row["unit"] and one["outcome"] in FINISHED}
    if not _partner_deleted(stored, row):
        yield from (f"the round {key} is missing" for key in sorted(log.rounds - played))


def _partner_deleted(stored: StoredData, row: Row) -> bool:
    """Whether the rounds of the pair were deleted because one of the two asked for it."""
    return any(one["unit"] == row["unit"] and one["keep"] is False for one in stored.participants.values())


def _doubled_rounds(stored: StoredData) -> Iterator[str]:
    done = Counter((one["unit"], one["step"]) for one in stored.rounds if one["valid"] and one["outcome"] in FINISHED)
    for (unit, step), count in done.items():
        if count > 1:
            yield f"unit {unit} finished the round {step} {count} times"


def _recordings(folder: StudyFolder, stored: StoredData) -> Iterator[str]:
    """Every finished round has one recording with as many ticks as its row says; others are of tutorials only."""
    found, broken = list_recordings(folder.recordings) if folder.recordings.is_dir() else ([], [])
    yield from (f"{one.path.name} cannot be read: {one.problem}" for one in broken)
    found = [one for one in found if one.source != "tutorial"]
    ticks = {one.id: one.ticks for one in found}
    yield from (
        f"{name} is recorded {count} times" for name, count in Counter(o.id for o in found).items() if count > 1
    )
    yield from (
        f"the recording {name} belongs to no round" for name in ticks.keys() - {one["episode"] for one in stored.rounds}
    )
    for one in stored.rounds:
        name = f"the round {one['step']} of unit {one['unit']}"
        if one["outcome"] is None:
            yield f"{name} was never closed"
        elif one["outcome"] in FINISHED and ticks.get(one["episode"]) != one["ticks"]:
            yield f"{name} has {one['ticks']} ticks; its recording {ticks.get(one['episode'], 'is missing')}"
