"""A finished study as files for analysis: tables as CSV, Parquet and JSON, a codebook, the recordings, a training set.

An export contains pseudonyms only, no completion codes and no identities. Free text is as people typed it; read it
before publishing.
"""

import csv
import json
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from hashlib import file_digest
from pathlib import Path
from typing import Any

from sqlalchemy import BigInteger, Boolean, Column, Float, Integer, Table

from movingout.maps import MapError
from movingout.maps.extras import needs_extra
from movingout.maps.suggestion import counted
from movingout.recordings.episode import FINISHED
from movingout.recordings.errors import RecordingError
from movingout.recordings.exports import export as export_recordings
from movingout.recordings.exports.plan import ExportPlan
from movingout.recordings.exports.target import new_target
from movingout.recordings.file_format.journal import JOURNAL_SUFFIX
from movingout.recordings.spreadsheet import safe_cells
from movingout.recordings.storage.index import path_of
from movingout.study.data.codebook import DERIVED, codebook
from movingout.study.data.map_copies import copy_own_maps
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.allocation import assign
from movingout.study.design.definition import Study
from movingout.study.design.steps import steps
from movingout.study.errors import StudyError
from movingout.study.questionnaire import NO_ANSWER
from movingout.study.store.frozen_study import code_by_time, frozen_study
from movingout.study.store.removal import undecided
from movingout.study.store.store import Store
from movingout.study.store.tables import exported

FORMATS = ("csv", "parquet", "json")
RELEASE = "release"  # the box of the consent that allows publishing
FEW = 5  # members of a smaller group may be recognised
Row = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Options:
    """What to export."""

    formats: Sequence[str] = FORMATS
    test_share: float = 0.2  # of the training set, by participants
    training: bool = True
    released: bool = False  # without those who did not allow publishing


@dataclass(slots=True)
class Exported:
    """What was written, and warnings for the experimenter."""

    rows: dict[str, int] = field(default_factory=dict)
    recordings: int = 0
    repeated: int = 0  # rounds that are a further attempt at the same round
    missing: list[str] = field(default_factory=list)  # ids of recordings that are not in the recordings folder
    warnings: list[str] = field(default_factory=list)


def export_study(folder: StudyFolder, store: Store, target: Path, options: Options) -> Exported:
    """Write everything to a new folder, which appears complete or not at all. Raises StudyError."""
    done = Exported()
    study, frozen = folder.study, frozen_study(store)
    tables = _tables(study, store)
    done.warnings += _leave_out_refused(tables)
    done.warnings += _leave_out_unreleased(study, tables, options.released)
    done.repeated = sum(row["attempt"] > 1 for row in tables["rounds"])
    tables["recordings"] = _manifest(folder.recordings, tables["rounds"], done)
    done.warnings += _small_groups(study, tables["answers"])
    try:
        with new_target(target) as part:
            part.mkdir()
            for name, rows in tables.items():
                _write(part, name, rows, _columns(store, name), options.formats)
                done.rows[name] = len(rows)
            (part / "study.yaml").write_text(frozen.file_text, encoding="utf-8")
            copy_own_maps(study, part)
            about: Row = {"study": frozen.id, "protocol": study.protocol, "file_sha256": frozen.file_sha256}
            about |= {"code": frozen.code, "models": frozen.models, "simulated": frozen.simulated}
            about |= {"allocation": frozen.allocation, "code_by_time": code_by_time(store)}
            (part / "about.json").write_text(json.dumps(about, indent=2), encoding="utf-8")
            (part / "codebook.md").write_text(codebook(study, store), encoding="utf-8")
            done.warnings += _training(folder.recordings, part / "training", tables, options)
    except RecordingError as error:
        raise StudyError(str(error)) from error
    if frozen.simulated:
        done.warnings.append("the participants were simulated: this is the export of a rehearsal")
    store.audit("experimenter", "export", rows=sum(done.rows.values()), recordings=done.recordings)
    return done


# ---- tables -----------------------------------------------------------------------------------------------------


def _tables(study: Study, store: Store) -> dict[str, list[Row]]:
    tables = {}
    for name, table in store.tables().items():
        names = [column.name for column in exported(table)]
        tables[name] = [{key: row[key] for key in names} for row in store.rows(table)]
    waiting = undecided(store)
    tables["participants"] = [row for row in tables["participants"] if row["pid"] not in waiting]
    _mark_newest(tables["answers"])
    tables["allocation"] = list(_allocation(study, tables["units"]))
    _name_maps(study, [*tables["rounds"], *tables["allocation"]])
    return tables


def _leave_out_refused(tables: dict[str, list[Row]]) -> list[str]:
    """Leave out what is still there of people who said "delete", as the server is about to; a warning says so."""
    people = [row for row in tables["participants"] if row["keep"] is False]
    left_out = _leave_out(tables, people)
    people_text = counted(len(people), "participant")
    return [f"{people_text} wanted their data deleted: {counted(left_out, 'row')} left out"] if left_out else []


def _leave_out_unreleased(study: Study, tables: dict[str, list[Row]], released: bool) -> list[str]:
    """Leave out who did not tick the box that allows publishing, or warn of them. Raises StudyError without a box."""
    if not any(box.id == RELEASE for box in study.consent.boxes):
        if released:
            raise StudyError(f"the consent has no box {RELEASE!r}, so nobody was asked about publishing (--released)")
        return []
    allowed = {row["pid"] for row in tables["consents"] if RELEASE in json.loads(row["boxes"])}
    people = [row for row in tables["participants"] if row["pid"] not in allowed]
    if released:
        _leave_out(tables, people)
        for name in ("participants", "consents"):
            tables[name] = [row for row in tables[name] if row["pid"] in allowed]
    without = sum(row["keep"] is not False for row in people)
    what = "left out" if released else "--released leaves them out, before publishing"
    people_text = counted(without, "participant")
    return [f"{people_text} did not allow publishing (the box {RELEASE!r} of the consent): {what}"] if without else []


def _leave_out(tables: dict[str, list[Row]], people: Sequence[Row]) -> int:
    """Answers, rounds and notes of these; returns how many rows.

    A game of two goes for both, as in study/store/removal.py.
    """
    pids = {row["pid"] for row in people}
    units = {row["unit"] for row in people} - {None}
    rounds = {row["id"] for row in tables["rounds"] if row["unit"] in units}
    refused: dict[str, Callable[[Row], bool]] = {
        "answers": lambda row: row["pid"] in pids,
        "rounds": lambda row: row["id"] in rounds,
        "players": lambda row: row["round"] in rounds or row["pid"] in pids,
        "notes": lambda row: row["unit"] in units or any(pid in row["text"] for pid in pids),
    }
    before = sum(len(tables[name]) for name in refused)
    for name, is_refused in refused.items():
        tables[name] = [row for row in tables[name] if not is_refused(row)]
    return before - sum(len(tables[name]) for name in refused)


def _mark_newest(answers: list[Row]) -> None:
    """Mark the newest answer to each item, the one that counts."""
    newest = {(row["pid"], row["step"], row["item"]): row["id"] for row in answers}
    for row in answers:
        row["counts"] = newest[row["pid"], row["step"], row["item"]] == row["id"]


def _name_maps(study: Study, rows: Iterable[Row]) -> None:
    """Give rows the name that recordings have for their map: of a file it is the name inside, not the path."""
    names: dict[str, str | None] = {}
    for row in rows:
        if row["map"] not in names:
            names[row["map"]] = None
            with suppress(MapError):  # its file has gone since: what was played is worth exporting all the same
                names[row["map"]] = study.load_map(row["map"]).name
        row["map_name"] = names[row["map"]]


def _allocation(study: Study, units: Iterable[Row]) -> Iterable[Row]:
    """The planned rounds of each unit, in order."""
    for unit in units:
        planned = (step for step in steps(study, assign(study, unit["slot"])) if step.turn)
        for position, step in enumerate(planned, 1):
            assert step.turn
            yield {
                "unit": unit["id"],
                "slot": unit["slot"],
                "position": position,
                "block": step.block,
                "partner": step.partner,
                "map": step.turn.map,
                "seat": step.turn.seat,
                "variant_seed": step.turn.variant_seed,
                "step": step.key,
            }


def _manifest(folder: Path, rounds: Iterable[Row], done: Exported) -> list[Row]:
    """The file and the hash of each recording that is finished: a journal still grows, and gets another name."""
    manifest, unfinished = [], 0
    for row in rounds:
        try:
            path = path_of(folder, row["episode"])
        except RecordingError:
            if row["ticks"] != 0:  # else the server was killed before the first tick
                done.missing.append(row["episode"])
            continue
        if path.name.endswith(JOURNAL_SUFFIX):
            unfinished += 1
            continue
        with path.open("rb") as stream:
            digest = file_digest(stream, "sha256").hexdigest()
        manifest.append({"episode": row["episode"], "round": row["id"], "file": path.name, "sha256": digest})
    done.recordings = len(manifest)
    if unfinished:
        done.warnings.append(f"rounds not finished yet, whose recordings are left out: {unfinished}")
    return manifest


def _columns(store: Store, name: str) -> dict[str, type]:
    """The columns of a table with their types, even where it has no rows."""
    table: Table | None = store.tables().get(name)
    kept = exported(table) if table is not None else []
    return {column.name: _type(column) for column in kept} | {
        column: made.kind for column, made in DERIVED.get(name, {}).items()
    }


def _type(column: Column[Any]) -> type:
    if isinstance(column.type, Boolean):
        return bool
    if isinstance(column.type, Integer | BigInteger):
        return int
    return float if isinstance(column.type, Float) else str


# ---- files ------------------------------------------------------------------------------------------------------


def _write(folder: Path, name: str, rows: Sequence[Row], columns: dict[str, type], formats: Sequence[str]) -> None:
    if "csv" in formats:
        with (folder / f"{name}.csv").open("w", encoding="utf-8", newline="") as stream:
            writer = csv.DictWriter(stream, list(columns))
            writer.writeheader()
            writer.writerows(map(safe_cells, rows))
    if "json" in formats:
        (folder / f"{name}.json").write_text(json.dumps(rows, indent=1, ensure_ascii=False), encoding="utf-8")
    if "parquet" in formats:
        _write_parquet(folder / f"{name}.parquet", rows, columns)


def _write_parquet(path: Path, rows: Sequence[Row], columns: dict[str, type]) -> None:
    with needs_extra("export", "Parquet (--formats csv json does without)"):
        import pyarrow as pa
        import pyarrow.parquet as pq
    types = {bool: pa.bool_(), int: pa.int64(), float: pa.float64(), str: pa.string()}
    schema = pa.schema([(name, types[kind]) for name, kind in columns.items()])
    pq.write_table(pa.Table.from_pylist(list(rows), schema), path)


def _training(folder: Path, target: Path, tables: dict[str, list[Row]], options: Options) -> list[str]:
    """The valid rounds in the official format, split so that no participant is in both parts. Returns warnings."""
    valid = {row["episode"] for row in tables["rounds"] if row["valid"] and row["outcome"] in FINISHED}
    files = [folder / row["file"] for row in tables["recordings"] if row["episode"] in valid]
    warnings: list[str] = []
    if options.training and files:
        export_recordings("official", ExportPlan(files, target, options.test_share, tell=warnings.append))
    return warnings


def _small_groups(study: Study, answers: Iterable[Row]) -> list[str]:
    """A warning about demographic answers that so few people share that they may be recognised."""
    if not study.demographics:
        return []
    given = [row for row in answers if row["counts"] and row["step"] == "form" and row["value"] != NO_ANSWER]
    groups = Counter((row["item"], row["value"]) for row in given)
    items = sorted({item for (item, _), count in groups.items() if count < FEW})
    if not items:
        return []
    return [f"fewer than {FEW} people share an answer to: {', '.join(items)}; merge answers before publishing"]
