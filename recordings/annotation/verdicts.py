"""Verdicts of annotators on findings: one line of JSON per click, beside the recordings; the newest of each counts."""

import json
import re
import unicodedata
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from movingout.maps.files.file_lock import wait_for_lock
from movingout.maps.files.output_file import draft_of
from movingout.maps.files.ownership import make_file
from movingout.recordings.annotation.finding import VERDICTS, SearchedRecording, Verdict, case_of
from movingout.recordings.errors import RecordingError, cannot
from movingout.recordings.text_lines import append_line, read_lines

VERDICTS_NAME = "annotations.jsonl"
LOCK_NAME = ".annotations.lock"  # empty, and locked by who writes the other file, which a deletion replaces
FORMAT = 1
_ANNOTATOR = re.compile(r"\w[\w .'·-]*")
_APOSTROPHES = str.maketrans(
    dict.fromkeys("’`´", "'")
)  # telephones write another one than keyboards: it is the same person
_LONGEST = 40
LONGEST_NOTE = 500  # letters


@dataclass(frozen=True, slots=True)
class VerdictLine:
    """What one annotator said about one finding."""

    finding: str  # id
    verdict: Verdict
    annotator: str
    at: str  # UTC, ISO 8601
    study: str = ""  # id of the recording's study
    note: str = ""

    @property
    def recording(self) -> str:
        return self.finding.partition(":")[0]


Verdicts = Mapping[str, Mapping[str, VerdictLine]]
"""The newest line of each annotator on each finding: by id of the finding, then by annotator."""


def checked_annotator(name: str) -> str:
    """The name without spaces around it, with one kind of apostrophe. Raises RecordingError if it cannot be one."""
    name = name.strip().translate(_APOSTROPHES)
    letters = "".join(sign for sign in name if not unicodedata.category(sign).startswith("M"))  # without vowel signs
    if len(name) > _LONGEST or not _ANNOTATOR.fullmatch(letters):
        raise RecordingError("an annotator's name has 1 to 40 letters, digits, spaces, dots, hyphens and apostrophes")
    return name


def add_verdict(folder: Path, line: VerdictLine) -> None:
    """Append and fsync. Blocks for the disk: call it in a thread. Raises OSError."""
    with _alone(folder):
        append_line(folder / VERDICTS_NAME, json.dumps({"format": FORMAT, **asdict(line)}, ensure_ascii=False))


@contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """Nobody else writes verdicts: one that is added to a file while it is replaced would be lost. Raises OSError."""
    make_file(folder / LOCK_NAME)
    with (folder / LOCK_NAME).open("ab") as stream:
        wait_for_lock(stream.fileno())
        yield


def new_line(finding: str, verdict: str, annotator: str, study: str = "", note: str = "") -> VerdictLine:
    """A line of now. Raises RecordingError for what no annotator can have said."""
    if verdict not in VERDICTS:
        raise RecordingError(f"{verdict!r} is no verdict; known: {', '.join(VERDICTS)}")
    try:
        case_of(finding)
    except ValueError as error:
        raise RecordingError(str(error)) from error
    at = datetime.now(UTC).isoformat(timespec="seconds")
    return VerdictLine(finding, verdict, checked_annotator(annotator), at, study, note.strip()[:LONGEST_NOTE])


def read_verdicts(file: Path) -> list[VerdictLine]:
    """The lines of a file in order; one cut short by a crash is left out. Raises RecordingError for other files."""
    try:
        texts = read_lines(file)
    except OSError as error:
        raise cannot("read", file, error) from error
    lines = [line for line in map(_line, texts) if line is not None]
    if texts and not lines:
        raise RecordingError(f"{file} is no file of annotations; `{VERDICTS_NAME}` beside the recordings is one")
    return lines


def verdicts_of(folder: Path) -> list[VerdictLine]:
    """The lines beside the recordings of a folder; none when nobody has annotated there."""
    file = folder / VERDICTS_NAME
    return read_verdicts(file) if file.exists() else []


def newest(lines: Iterable[VerdictLine]) -> Verdicts:
    found: dict[str, dict[str, VerdictLine]] = {}
    for line in lines:
        found.setdefault(line.finding, {})[line.annotator] = line
    return found


def annotations(folder: Path, more: Iterable[Path], recordings: Iterable[SearchedRecording]) -> Verdicts:
    """The verdicts beside the recordings and those in further files, such as other annotators sent.

    Raises RecordingError for a file that is about none of these recordings.
    """
    there = list(recordings)
    ids = {one.id for one in there}
    lines = [line for line in verdicts_of(folder) if line.recording in ids]
    for file in more:
        given = read_verdicts(file)
        about = [line for line in given if line.recording in ids]
        if given and not about:
            studies = " and ".join(sorted({line.study for line in given} - {""})) or "other recordings"
            here = " and ".join(sorted({one.study for one in there} - {""})) or str(folder)
            raise RecordingError(f"{file} annotates {studies}, not {here}: none of its recordings is here")
        lines += about
    return newest(sorted(lines, key=lambda line: line.at))


def forget_recordings(folder: Path, recordings: set[str]) -> None:
    """Remove what was said about recordings that are deleted; other lines stay as they are. Raises OSError."""
    file = folder / VERDICTS_NAME
    if not file.exists():
        return
    with _alone(folder):
        lines = read_lines(file)
        kept = [line for line in lines if not _is_about(line, recordings)]
        if len(kept) < len(lines):
            with draft_of(file) as draft:
                draft.write_text("".join(f"{line}\n" for line in kept), encoding="utf-8", newline="\n")


def _is_about(text: str, recordings: set[str]) -> bool:
    """Whether a line is about one of them; one that is not understood, such as one cut short, when it names one."""
    line = _line(text)
    return any(name in text for name in recordings) if line is None else line.recording in recordings


def _line(text: str) -> VerdictLine | None:
    try:
        document: dict[str, Any] = json.loads(text)
        if document["format"] != FORMAT:
            return None
        case_of(document["finding"])
        if document["verdict"] not in VERDICTS:
            return None
        return VerdictLine(
            document["finding"],
            document["verdict"],
            str(document["annotator"]),
            str(document["at"]),
            str(document.get("study", "")),
            str(document.get("note", "")),
        )
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return None
