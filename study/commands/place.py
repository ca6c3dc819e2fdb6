"""Options of the commands for data: which folder and databases hold a study."""

import argparse
from contextlib import suppress
from pathlib import Path

from movingout.maps.commands.parser import filled, folder
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.definition import Study
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
    """The same also where the study file has faults, is no YAML or has gone; and a sentence about that, "" for none.

    Of the study there is then but its id: that of the file, or of the only study in the data folder. Raises StudyError.
    """
    addresses = databases(args)
    try:
        return StudyFolder(read_study(args.file), args.data, *addresses), ""
    except StudyError as error:
        study = _unread(args.file, args.data, error)
        told = f"the study file cannot be read: {error}" if isinstance(error, StudyFileError) else str(error)
        return StudyFolder(study, args.data, *addresses), f"{told}\nthe data of the study {study.id} were copied"


def _unread(file: Path, data: Path, problem: StudyError) -> Study:
    there = sorted(path.name for path in (data / "studies").glob("*/") if path.suffix != ".part")
    with suppress(StudyError):
        return unread_study(file, there[0] if len(there) == 1 else "")
    if not there:
        raise problem from None
    several = f"{data} has data of {', '.join(there)}; say which in a line of the file, id: NAME"
    raise StudyError(f"{problem}\n{several}") from None
