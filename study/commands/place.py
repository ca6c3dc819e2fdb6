"""Options of the commands for data: which folder and databases hold a study."""

import argparse
import sys
from contextlib import closing, suppress
from dataclasses import replace
from pathlib import Path

from movingout.maps.commands.parser import filled, folder
from movingout.maps.files.terminal import printable_lines
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.definition import Study
from movingout.study.design.study_file import codes_of, read_study, unread_study
from movingout.study.errors import StudyError, StudyFileError
from movingout.study.store.frozen_study import frozen_study
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


def folder_of(args: argparse.Namespace, *, deletes: bool = False) -> StudyFolder:
    """Where the data of the study are, with the study as it began where its file has got faults.

    A file that says no id stands for the only study of the data folder, but where the command `deletes`. Raises
    StudyError.
    """
    addresses = databases(args)
    try:
        return StudyFolder(read_study(args.file), args.data, *addresses)
    except StudyFileError as error:
        begun = _begun(args, error, deletes)
        _warn(f"{error}\n{args.file} is not used, but the study as it began")
        return begun
    except StudyError as error:  # it has gone, or may not be read
        if any((args.data / "studies").glob("*/study.sqlite")):
            raise StudyError(f"{error}; `movingout study backup` writes it as it was when the study began") from None
        raise


def folder_to_forget(args: argparse.Namespace) -> StudyFolder:
    """The same also where neither text can be read, as when a map has gone: whose data these are is known all the same.

    Of the study there are then but its id and its codes. Raises StudyError.
    """
    try:
        return folder_of(args, deletes=True)
    except StudyFileError as error:
        folder = StudyFolder(_unread(args.file, args.data, error, deletes=True), args.data, *databases(args))
        with closing(folder.open_existing()) as store:
            codes = codes_of(frozen_study(store).file_text)
        _warn(str(error))
        return replace(folder, study=folder.study.model_copy(update={"codes": codes}))


def _warn(sentence: str) -> None:
    """On standard error; it may quote a study file of somebody else."""
    print(printable_lines(f"warning: {sentence}"), file=sys.stderr)


def _begun(args: argparse.Namespace, problem: StudyFileError, deletes: bool) -> StudyFolder:
    """The folder with the study that its database keeps. Raises the `problem` of its file where that cannot be read."""
    folder = StudyFolder(_unread(args.file, args.data, problem, deletes=deletes), args.data, *databases(args))
    try:
        with closing(folder.open_existing()) as store:
            begun = folder.as_frozen(store, args.file.parent)
    except StudyError:
        raise problem from None
    if begun.study.id != folder.study.id:  # a database of PostgreSQL that is another study's
        raise problem from None
    return begun


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


def _unread(file: Path, data: Path, problem: StudyError, *, deletes: bool = False) -> Study:
    there = sorted(path.name for path in (data / "studies").glob("*/") if path.suffix != ".part")
    with suppress(StudyError):
        return unread_study(file, there[0] if len(there) == 1 and not deletes else "")
    if not there:
        raise problem from None
    several = f"{data} has data of {', '.join(there)}; say which in a line of the file, id: NAME"
    raise StudyError(f"{problem}\n{several}") from None
