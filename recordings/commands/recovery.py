"""`movingout recordings recover`: finishes what a crash left behind, and saves the intact part of a damaged file."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from movingout.maps.commands.parser import add_json
from movingout.maps.commands.sentences import tell
from movingout.maps.files.terminal import printable
from movingout.recordings.commands.arguments import add_data, data_folder, print_json
from movingout.recordings.errors import RecordingError
from movingout.recordings.file_format.journal import JOURNAL_SUFFIX
from movingout.recordings.storage.finished import SUFFIX, Recovery, recover, recover_journal
from movingout.recordings.storage.repair import damaged_below, recover_recording

_FAILED = 2  # as for a file that is named and cannot be recovered


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("paths", nargs="*", type=Path, metavar="FILE|DIR", help="default: DATA/recordings")
    parser.add_argument(
        "--all", action="store_true", help="in folders, end rounds, too, that a server goes on with when started again"
    )
    add_data(parser)
    add_json(parser)
    parser.set_defaults(perform=perform)


def perform(args: argparse.Namespace) -> int:
    """Recover what is named and print what became of it. Raises RecordingError for a data folder that is not there."""
    done: list[Recovery] = []
    usual = data_folder(args) / "recordings"
    for path in args.paths or ([usual] if usual.exists() else []):
        try:
            done += _recovered(path, args.all)
        except RecordingError as error:  # the other files that were named are tried all the same
            done.append(Recovery(path, None, 0, str(error), failed=True))
    if args.json:
        print_json({"journals": [_document(entry) for entry in done]})
    else:
        _print_lines(done)
    return _FAILED if any(entry.failed for entry in done) else 0


def _print_lines(done: Sequence[Recovery]) -> None:
    for entry in done:
        if entry.failed:
            where = "" if entry.note.startswith(entry.journal.name) else f"{entry.journal.name}: "
            tell(printable(f"{where}{entry.note}"))
            continue
        made = f" -> {entry.recording.name}" if entry.recording not in (None, entry.journal) else ""
        print(printable(f"{entry.journal.name}{made}: {entry.ticks} ticks, {entry.note}"))
    if not done:
        print("nothing to recover")


def _document(entry: Recovery) -> dict[str, object]:
    return {
        "journal": str(entry.journal),
        "recording": str(entry.recording) if entry.recording else None,
        "ticks": entry.ticks,
        "note": entry.note,
        "failed": entry.failed,
    }


def _recovered(path: Path, also_waiting: bool) -> list[Recovery]:
    """What became of a journal, a finished file, or a folder's journals and those below, and what is damaged there.

    Raises RecordingError for other files.
    """
    if path.is_dir():
        return recover(path, also_waiting) + _damaged(path)
    if path.name.endswith(JOURNAL_SUFFIX):
        return [recover_journal(path)]
    if path.exists() and not path.name.endswith(SUFFIX):
        raise RecordingError(f"{path.name} is neither a recording (*{SUFFIX}) nor a journal (*{JOURNAL_SUFFIX})")
    return [recover_recording(path)]


def _damaged(folder: Path) -> list[Recovery]:
    """A folder that cannot be listed is one more problem: what was recovered before is told all the same."""
    try:
        return damaged_below(folder)
    except RecordingError as error:
        return [Recovery(folder, None, 0, str(error), failed=True)]
