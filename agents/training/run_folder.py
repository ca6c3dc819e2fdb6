"""The folder of a training run, DATA/runs/<id>. It keeps the configuration, so that only the same run is continued.

config.json            id, kind, preset, SHA-256 of the data and every field of the configuration
card.json              of the trained agent
resume.safetensors     with losses.jsonl and TensorBoard's events, see `training.loop`; for BASS also in folders here
"""

import dataclasses
import json
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path

from movingout.agents.checkpoint.checkpoint import CARD, Checkpoint
from movingout.agents.errors import DataError
from movingout.agents.training.optimisation import Change, Optimisation

CONFIG = "config.json"
RESUME = "resume.safetensors"
_CHANGES: dict[str, Change] = {"id": "never", "kind": "never", "data_sha256": "asked", "seats": "asked"}
_WORDS = {"id": "agent", "data_sha256": "data of SHA-256"}


def begin(folder: Path, about: Mapping[str, str], config: Optimisation, on_purpose: bool) -> str:
    """Write the configuration of a run that starts, or continues where the folder has a resume file.

    Returns the SHA-256 of the data it had before; empty when unknown. `about` is written beside the configuration.
    Raises DataError when the folder cannot be written, or the run was started with something else: always for a change
    that makes it another agent, and unless `on_purpose` for other data or training options. Older folders without a
    configuration are continued.
    """
    begun = _begun(folder)
    now = {**about, **dataclasses.asdict(config)}
    if any(folder.rglob(RESUME)):
        _compare(begun, now, config, on_purpose)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / CONFIG).write_text(json.dumps({**begun, **now}, indent=1) + "\n", encoding="utf-8")
    except OSError as error:
        raise DataError(f"cannot write {folder}: {error.strerror or error}") from error
    return str(begun.get("data_sha256", ""))


def put_back(folder: Path, data_sha256: str) -> None:
    """Restore the hash of the data that the run had before, since nothing was learned from the new data."""
    config = {**_begun(folder), "data_sha256": data_sha256}
    (folder / CONFIG).write_text(json.dumps(config, indent=1) + "\n", encoding="utf-8")


def finish(folder: Path, checkpoint: Checkpoint) -> None:
    """Copy the card of the trained agent into the folder."""
    shutil.copyfile(checkpoint.folder / CARD, folder / CARD)


def _begun(folder: Path) -> dict[str, object]:
    path = folder / CONFIG
    if not path.exists():
        return {}
    try:
        return dict(json.loads(path.read_text(encoding="utf-8")))
    except (ValueError, TypeError) as error:
        raise DataError(f"{path} does not say what the run was started with ({error}); choose another --id") from error


def _compare(begun: Mapping[str, object], now: Mapping[str, object], config: Optimisation, on_purpose: bool) -> None:
    """Raise DataError for changes with which the run must not be continued."""
    changes = {entry.name: entry.metadata["change"] for entry in dataclasses.fields(config)} | _CHANGES
    other = [name for name in now if name in begun and begun[name] != now[name]]
    never = [name for name in other if changes.get(name) == "never"]
    asked = [name for name in other if changes.get(name) == "asked"]
    if never:
        raise DataError(f"{_differences(begun, now, never)}; train that under another --id")
    if asked and not on_purpose:
        raise DataError(f"{_differences(begun, now, asked)}; choose another --id, or continue with --go-on")


def _differences(begun: Mapping[str, object], now: Mapping[str, object], names: Sequence[str]) -> str:
    differences = [
        f"{_WORDS.get(name, name.replace('_', '-'))} {_short(begun[name])}, not {_short(now[name])}" for name in names
    ]
    return f"this run was started with {'; '.join(differences)}"


def _short(value: object) -> str:
    """A value as typed; a hash is shortened."""
    text = {True: "yes", False: "no"}[value] if isinstance(value, bool) else str(value)
    return f"{text[:12]}…" if len(text) == 64 else text or "none"
