"""The folder of a training run, DATA/runs/<id>. It keeps the configuration, so that only the same run is continued.

config.json            id, kind, preset, SHA-256 of the data, every field of the configuration, and maps and items of
                       all that was ever learned from, see `training.learned_data`
card.json              of the trained agent
.lock                  held by the process that trains
resume.safetensors     with losses.jsonl and TensorBoard's events, see `training.loop`; for BASS also in folders here
"""

import ast
import dataclasses
import json
import os
import re
import shlex
import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from types import MappingProxyType

from movingout.agents.checkpoint.checkpoint import CARD, Checkpoint
from movingout.agents.errors import DataError
from movingout.agents.training.optimisation import Change, Optimisation
from movingout.maps.files.file_lock import lock_file
from movingout.maps.files.output_file import draft_of
from movingout.maps.suggestion import shortened

CONFIG = "config.json"
RESUME = "resume.safetensors"
LOCK = ".lock"
_CHANGES: Mapping[str, Change] = MappingProxyType(
    {
        "id": "never", "kind": "never", "start": "never", "data_sha256": "asked", "seats": "asked", "map": "asked",
        "split": "asked", "partners": "asked", "ticks": "asked",
    }
)  # fmt: skip
"""Of what is no field of the configuration; the rest is free. Weights start from `start` once, at the beginning."""
_BEFORE: Mapping[str, object] = MappingProxyType({"start": ""})
"""What was done by runs that are older than an option; fields of a configuration say it themselves."""
NO_CHANGES: Mapping[str, Change] = MappingProxyType({})
NOTHING_MORE: Mapping[str, object] = MappingProxyType({})
_SHA256 = re.compile("[0-9a-f]{64}")
_WORDS = {"id": "agent", "data_sha256": "data of SHA-256"}


@contextmanager
def held(folder: Path) -> Iterator[None]:
    """Make a run folder, and keep other processes out of it within the block.

    Raises DataError where another one trains there, or it cannot be written. Where a file system has no locks, nobody
    is kept out.
    """
    with ExitStack() as undo:
        try:
            folder.mkdir(parents=True, exist_ok=True)
            descriptor = os.open(folder / LOCK, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)  # a group may share it
            undo.callback(os.close, descriptor)
        except OSError as error:
            raise _cannot_write(folder, error) from error
        if not _locked(descriptor, folder):
            raise DataError(f"another process trains in {folder}; wait until it is over, or choose another --id")
        yield


def _locked(descriptor: int, folder: Path) -> bool:
    """Whether no other process has the lock."""
    try:
        return lock_file(descriptor)
    except OSError as error:
        raise DataError(f"cannot lock {folder}: {error.strerror or error}") from error


def begin(
    folder: Path, about: Mapping[str, str], config: Optimisation, on_purpose: bool,
    changes: Mapping[str, Change] = NO_CHANGES, more: Mapping[str, object] = NOTHING_MORE,
) -> dict[str, object]:  # fmt: skip
    """Write the configuration of a run that starts, or continues where the folder has a resume file.

    Returns what was written before; empty when nothing was, or nothing was learned. `about` is written beside the
    configuration, and `changes` says which of it may be another, where a kind is stricter than others; `more` is
    written, too, and may always be another. Raises DataError when the folder cannot be
    written, or the run was started with something else: always for a change that makes it another agent, and unless
    `on_purpose` for other data or training options. Older folders without a configuration are continued; one that
    lacks a field was trained as the field's `before` says.
    """
    before = begun(folder) if has_learned(folder) else {}
    now = {**about, **dataclasses.asdict(config)}
    if has_learned(folder):
        allowed = {entry.name: entry.metadata["change"] for entry in dataclasses.fields(config)}
        used = {name: value for name, value in now.items() if name not in config.UNUSED}
        _compare({**_meant(config), **before} if before else {}, used, {**allowed, **_CHANGES, **changes}, on_purpose)
    _write(folder, {**before, **now, **more})
    return before


def rename_data(folder: Path, before: str, now: str) -> None:
    """Note that data of this SHA-256 have another one now. Raises DataError where it cannot be written."""
    configuration = begun(folder)
    if configuration.get("data_sha256") == before:
        _write(folder, {**configuration, "data_sha256": now})


def has_learned(folder: Path) -> bool:
    """Whether there are weights to go on with."""
    return any(folder.rglob(RESUME))


def begun(folder: Path) -> dict[str, object]:
    """The configuration as it was written last; empty when none was. Raises DataError for a damaged one."""
    path = folder / CONFIG
    if not path.exists():
        return {}
    try:
        return dict(json.loads(path.read_text(encoding="utf-8")))
    except (ValueError, TypeError) as error:
        raise DataError(f"{path} does not say what the run was started with ({error}); choose another --id") from error


def learns_from_other(folder: Path, before: Mapping[str, object]) -> bool:
    """Whether the run, which had what `begin` returned, now has other data, maps, partners or seats."""
    now = begun(folder)
    asked = [name for name, change in _CHANGES.items() if change == "asked"]
    return any(before.get(name) not in (None, "", now.get(name)) for name in asked)


def put_back(folder: Path, before: Mapping[str, object]) -> None:
    """Restore what `begin` returned, since nothing was learned from what was new.

    Raises DataError where it cannot be written.
    """
    _write(folder, before)


def finish(folder: Path, checkpoint: Checkpoint) -> None:
    """Copy the card of the trained agent into the folder. Raises DataError."""
    try:
        with draft_of(folder / CARD) as draft:
            shutil.copyfile(checkpoint.folder / CARD, draft)
    except OSError as error:
        raise _cannot_write(folder, error) from error


def _write(folder: Path, configuration: Mapping[str, object]) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with draft_of(folder / CONFIG) as draft:
            draft.write_text(json.dumps(configuration, indent=1) + "\n", encoding="utf-8")
    except OSError as error:
        raise _cannot_write(folder, error) from error


def _cannot_write(folder: Path, error: OSError) -> DataError:
    return DataError(f"cannot write {folder}: {error.strerror or error}")


def _meant(config: Optimisation) -> dict[str, object]:
    """What a configuration meant that was written before it had all of its fields."""
    said = {entry.name: entry.metadata["before"] for entry in dataclasses.fields(config)}
    return {**_BEFORE, **{name: value for name, value in said.items() if value is not None}}


def _compare(
    before: Mapping[str, object], now: Mapping[str, object], changes: Mapping[str, Change], on_purpose: bool
) -> None:
    """Raise DataError for changes with which the run must not be continued."""
    other = [name for name in now if name in before and before[name] != now[name]]
    never = [name for name in other if changes.get(name) == "never"]
    asked = [name for name in other if changes.get(name) == "asked"]
    if never:
        raise DataError(f"{_differences(before, now, never)}; {_way_on(before, never)}train that under another --id")
    if asked and not on_purpose:
        raise DataError(f"{_differences(before, now, asked)}; choose another --id, or continue with --go-on")


def _differences(before: Mapping[str, object], now: Mapping[str, object], names: Sequence[str]) -> str:
    differences = [
        f"{_WORDS.get(name, name.replace('_', '-'))} {_short(before[name])}, not {_short(now[name])}" for name in names
    ]
    return f"this run was started with {'; '.join(differences)}"


def _way_on(before: Mapping[str, object], names: Sequence[str]) -> str:
    """Which options continue the run as it was begun; empty where it is of another agent or kind."""
    if {"id", "kind"} & set(names):
        return ""
    options = (f"--{name.replace('_', '-')} {shlex.quote(_typed(before[name]))}" for name in names)
    return f"to continue it, add {' '.join(options)}, or "


def _typed(value: object) -> str:
    return {True: "yes", False: "no"}[value] if isinstance(value, bool) else str(value)


def _short(value: object) -> str:
    """A value as typed; a hash is shortened, and so is a long list."""
    text = _typed(value)
    if text.startswith("['"):  # a list is kept as Python writes it
        text = " ".join(ast.literal_eval(text))
    if text in ("", "None"):
        return "none"
    return f"{text[:12]}…" if _SHA256.fullmatch(text) else shortened(text)
