"""`movingout study` backup and restore."""

import argparse
import json
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

from movingout.maps.commands.parser import add_out
from movingout.maps.files.terminal import printable, printable_lines
from movingout.study.commands.place import add_databases, add_place, databases, folder_of_any
from movingout.study.data.backup import back_up, restore
from movingout.study.data.restore_check import check_backup
from movingout.study.errors import StudyError


def configure(commands: Any) -> None:
    """Add the sub-commands to those of `movingout study`."""
    backup = commands.add_parser(
        "backup",
        help="databases and recordings of a study in a new folder, also while it is served",
        example="movingout study backup study.yaml -o /backup/study-1",
    )
    add_place(backup)
    add_out(backup, "DIR", "default: ID-backup-DATE-TIME; never overwritten")
    backup.add_argument("--previous", type=Path, metavar="DIR", help="link recordings that this backup has, not copy")
    backup.add_argument("--no-identities", action="store_true", help="without recruitment ids: nobody can come back")
    backup.set_defaults(perform=_back_up)

    restoring = commands.add_parser(
        "restore",
        help="check a backup and put it into a data folder",
        example="movingout study restore /backup/study-1 --data data",
    )
    restoring.add_argument("backup", type=Path, metavar="BACKUP", help="a folder written by `backup`")
    add_databases(restoring)
    restoring.add_argument(
        "--check", action="store_true", help="only try it, in a temporary folder that is removed: is the backup good?"
    )
    restoring.add_argument("--json", action="store_true", help="one JSON document on standard output")
    restoring.set_defaults(perform=_restore)


def _back_up(args: argparse.Namespace) -> int:
    folder, faults = folder_of_any(args)
    target = args.out or Path(f"{folder.study.id}-backup-{time.strftime('%Y%m%d-%H%M%S')}")
    done = back_up(folder, target, time.time(), identities=not args.no_identities, previous=args.previous)
    if faults:
        done = replace(done, warnings=(*done.warnings, faults))
    if args.json:
        print(json.dumps({"backup": str(done.folder), "files": done.files, "bytes": done.size,
                          "recordings": done.recordings, "missing": done.missing,
                          "warnings": done.warnings}, indent=2))  # fmt: skip
        return 0
    print(f"wrote {done.folder}: {done.recordings} recordings, {done.size / 1e6:.1f} MB, every file with its checksum")
    for episode in done.missing:
        print(f"missing: the recording {printable(episode)} of a round is not in {folder.recordings}")
    for sentence in done.warnings:
        print(printable_lines(f"warning: {sentence}"))
    if done.identities:
        print("it holds the identities of the participants: keep it as safe as the data folder")
    return 0


def _restore(args: argparse.Namespace) -> int:
    database, identities = databases(args)
    if args.check:
        return _check(args, database or identities)
    done = restore(args.backup, args.data, database, identities)
    if args.json:
        print(json.dumps({"study": done.study, "data": str(args.data), "files": done.files, "bytes": done.size}))
        return 0
    print(f"restored {printable(done.study)} into {args.data}: {done.recordings} recordings, every checksum right")
    print(f"the study file as it was is {args.backup / 'study.yaml'}")
    return 0


def _check(args: argparse.Namespace, address: str | None) -> int:
    if address:
        raise StudyError("--check writes into no database; leave --database, --identities and --cluster out")
    done = check_backup(args.backup)
    if args.json:
        print(json.dumps({"study": done.study, "good": True, "files": done.files, "bytes": done.size}))
    else:
        good = f"the backup {args.backup} of {printable(done.study)} is good"
        print(f"{good}: restored and read, {done.recordings} recordings")
    return 0
