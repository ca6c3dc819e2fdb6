"""Recordings in other formats. Each format is a module that is imported only when it is asked for."""

import importlib
from typing import NamedTuple, Protocol, cast

from movingout.maps.extras import needs_extra
from movingout.recordings.errors import RecordingError
from movingout.recordings.exports.plan import ExportPlan


class Format(NamedTuple):
    """Where a format is written, what it is for, and which extra it needs."""

    module: str
    help: str
    library: str = ""
    extra: str = ""


class FormatModule(Protocol):
    """What a format's module offers."""

    def write(self, plan: ExportPlan) -> None: ...


FORMATS = {
    "parquet": Format("parquet", "tables with observations, for pandas, DuckDB, Spark", "pyarrow", "export"),
    "csv": Format("csv_tables", "tables for spreadsheets and R"),
    "lerobot": Format("lerobot", "a LeRobotDataset v3.0", "pyarrow", "export"),
    "robomimic": Format("robomimic", "one HDF5 file for robomimic", "h5py", "hdf5"),
    "official": Format("official", "the official Moving Out JSON, collector's files and data set rows"),
    "mp4": Format("mp4", "a video", "av", "video"),
    "gif": Format("gif", "an animation for a README"),
    "png": Format("strip", "a strip of pictures for a paper"),
}


def export(name: str, plan: ExportPlan) -> None:
    """Write the recordings of a plan in a format. The target appears whole or not at all; it is never overwritten."""
    if name not in FORMATS:
        raise RecordingError(f"unknown format {name!r}; known: {', '.join(FORMATS)}")
    if not plan.recordings:
        raise RecordingError("no recordings to export; name .mcap files or a folder that holds some")
    chosen = FORMATS[name]
    with needs_extra(chosen.extra, f"{name} ({chosen.library})" if chosen.library else name):
        module = cast(FormatModule, importlib.import_module(f"movingout.recordings.exports.{chosen.module}"))
    module.write(plan)
