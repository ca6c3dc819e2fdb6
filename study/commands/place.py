"""Options of the commands for data: which folder and databases hold a study."""

import argparse
from contextlib import suppress
from pathlib import Path

from movingout.maps.commands.parser import filled, folder
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.study_file import read_study, unread_study
from movingout.study.errors import StudyError, StudyFileError
from movingout.study.store.identity import identities_in

DATA = Path("data")


def add_place(parser: argparse.ArgumentParser) -> None:
    """FILE and where its data are."""
    parser.add_argument("file", type=Path, metavar="FILE", help="the study file")
    add_databases(parser)
    parser.add_argument("--json", action="store_true", help="one JSON document on standard output")


def add_databases(parser: argparse.ArgumentParser) -> None:
    """The data folder, and databases outside of it."""
    add = parser.add_argument
    add("--data", type=folder, default=DATA, metavar="DIR", help=f"default: {DATA}")
    add("--database", type=filled, metavar="URL", help="postgresql://...; default: a file in DIR")
    add("--identities", type=filled, metavar="URL", help="the database of identities; default: a file in DIR")
    add("--cluster", type=filled, metavar="URL", help="both databases of nodes that were served with this address")


def databases(args: argparse.Namespace) -> tuple[str | None, str | None]:
    """The addresses of data and of identities, None for files. Raises StudyError."""
    if not args.cluster:
        return args.database or None, args.identities or None
    if not args.cluster.startswith(("postgresql://", "postgres://")):
        raise StudyError(f"{args.cluster} is no address of PostgreSQL; it looks like postgresql://user@host/name")
    database = args.database or args.cluster
    return database, args.identities or identities_in(database)


def folder_of(args: argparse.Namespace) -> StudyFolder:
    """Where the data of the study are. Raises StudyError."""
    return StudyFolder(read_study(args.file), args.data, *databases(args))


def folder_of_any(args: argparse.Namespace) -> tuple[StudyFolder, str]:
    """The same also where the study file has faults, such as maps that lie elsewhere; and these, empty for none.

    Of the study there is then but its id. Raises StudyError.
    """
    try:
        return folder_of(args), ""
    except StudyFileError as error:
        with suppress(StudyError):
            return StudyFolder(unread_study(args.file), args.data, *databases(args)), str(error)
        raise
