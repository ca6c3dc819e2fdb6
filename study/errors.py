"""Errors of studies: in the study file, or in the place where the data are stored."""

from collections.abc import Sequence

from movingout.maps.errors import MovingOutError
from movingout.maps.yaml_document import FileFault


class StudyError(MovingOutError):
    """A study cannot do what was asked for."""


class StudyFileError(StudyError):
    """A study file with faults; the message has one line for each."""

    def __init__(self, name: str, faults: Sequence[FileFault]) -> None:
        self.faults = tuple(faults)
        count = "1 fault" if len(faults) == 1 else f"{len(faults)} faults"
        lines = [f"{name}:{fault.line}: {fault.path}: {fault.message}" for fault in faults]
        super().__init__("\n".join([f"{name} has {count}:", *lines]))


class StoreError(StudyError):
    """The database cannot be opened, read or written."""


class StoreFenced(StoreError):
    """Another server has taken over the writing of this database."""


class StoreLocked(StoreError):
    """Another program holds the database."""
