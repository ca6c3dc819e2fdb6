"""Recordings in other formats. Each format is a module that is imported only when it is asked for."""

import importlib
from typing import NamedTuple, Protocol, cast

from movingout.maps.extras import needs_extra
from movingout.recordings.errors import RecordingError, cannot
from movingout.recordings.exports.dataset_card import CARD, FILES, dataset_card
from movingout.recordings.exports.plan import ExportPlan


class Format(NamedTuple):
    """Where a format is written, what it is for, and which extra it needs."""

    module: str
    help: str
    library: str = ""
    extra: str = ""
    on_ray: bool = False  # whether a cluster can convert the episodes


class FormatModule(Protocol):
    """What a format's module offers."""

    def write(self, plan: ExportPlan) -> None: ...


FORMATS = {
    "parquet": Format("parquet", "tables with observations, for pandas, DuckDB, Spark", "pyarrow", "export", True),
    "csv": Format("csv_tables", "tables for spreadsheets and R", on_ray=True),
    "lerobot": Format("lerobot", "a LeRobotDataset v3.0", "pyarrow", "export", True),
    "robomimic": Format("robomimic", "one HDF5 file for robomimic", "h5py", "hdf5", True),
    "official": Format("official", "the official Moving Out JSON, collector's files and data set rows", on_ray=True),
    "mp4": Format("mp4", "a video", "av", "video"),
    "gif": Format("gif", "an animation for a README"),
    "rrd": Format("rrd", "a file for the Rerun viewer", "rerun-sdk", "rerun"),
    "png": Format("strip", "a strip of pictures for a paper"),
}


def export(name: str, plan: ExportPlan) -> None:
    """Write the recordings of a plan in a format. The target appears whole or not at all; it is never overwritten.

    Raises RecordingError.
    """
    if name not in FORMATS:
        raise RecordingError(f"unknown format {name!r}; known: {', '.join(FORMATS)}")
    if not plan.recordings:
        raise RecordingError("no recordings to export; name .mcap files or a folder that holds some")
    chosen = FORMATS[name]
    if plan.ray and (plan.images or not chosen.on_ray):
        able = ", ".join(one for one, described in FORMATS.items() if described.on_ray)
        raise RecordingError(f"pictures are drawn on this machine: leave --ray out (it works with --to {able})")
    with needs_extra(chosen.extra, f"{name} ({chosen.library})" if chosen.library else name):
        module = cast(FormatModule, importlib.import_module(f"movingout.recordings.exports.{chosen.module}"))
    module.write(plan)
    if name in FILES:
        _write_card(name, plan)


def _write_card(name: str, plan: ExportPlan) -> None:
    try:
        (plan.target / CARD).write_text(dataset_card(name, plan), encoding="utf-8")
    except OSError as error:
        raise cannot("write", plan.target / CARD, error) from error
