"""All findings as rows, with a column per annotator: what is exported as CSV."""

from collections.abc import Iterable
from typing import Any

from movingout.maps.spec import SEAT_COLOURS
from movingout.recordings.annotation.agreement import settled
from movingout.recordings.annotation.finding import SearchedRecording
from movingout.recordings.annotation.verdicts import Verdicts
from movingout.world.constants import TICK_SECONDS

COLUMNS = ("finding", "recording", "study", "map", "case", "seat", "kind", "item", "start_s", "end_s", "detail")
_SETTLED = {True: "confirmed", False: "rejected", None: ""}


def finding_rows(recordings: Iterable[SearchedRecording], verdicts: Verdicts) -> tuple[list[str], list[dict[str, Any]]]:
    """Column names, and a row per finding: the settled verdict, then that of each annotator and their notes."""
    names = sorted({name for lines in verdicts.values() for name in lines})
    rows = []
    for recording in recordings:
        for finding in recording.findings:
            lines = verdicts.get(finding.id, {})
            rows.append(
                {
                    "finding": finding.id,
                    "recording": recording.id,
                    "study": recording.study,
                    "map": recording.map,
                    "case": finding.case,
                    "seat": SEAT_COLOURS[finding.seat],
                    "kind": recording.seats[finding.seat].kind,
                    "item": finding.item,
                    "start_s": round(finding.start * TICK_SECONDS, 1),
                    "end_s": round(finding.end * TICK_SECONDS, 1),
                    "detail": finding.detail,
                    "verdict": _SETTLED[settled(lines.values())],
                    **{f"verdict {name}": lines[name].verdict if name in lines else "" for name in names},
                    **{f"note {name}": lines[name].note if name in lines else "" for name in names},
                }
            )
    said = [f"{what} {name}" for what in ("verdict", "note") for name in names]
    return [*COLUMNS, "verdict", *said], rows
