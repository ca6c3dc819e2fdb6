"""The folder of a training run, DATA/runs/<id>: what it was begun with, so that nothing else is gone on with unasked.

config.json            id, kind, preset, SHA-256 of the data and every field of the configuration
card.json              of the agent that came of it
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
    """Write what the run is begun with, or gone on with when something has been trained in the folder already.

    Returns the SHA-256 of the data it had before; empty when it had none, or the folder does not say.
    `about` is what config.json says beside the configuration. Raises DataError when the run was begun with something
    else: always for a change that makes another agent of it, and unless it is `on_purpose` for other data and for
    another way to train. A folder that says nothing of it, because it is older, is gone on with.
    """
    begun = _begun(folder)
    now = {**about, **dataclasses.asdict(config)}
    if any(folder.rglob(RESUME)):
        _compare(begun, now, config, on_purpose)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / CONFIG).write_text(json.dumps({**begun, **now}, indent=1) + "\n", encoding="utf-8")
    return str(begun.get("data_sha256", ""))


def put_back(folder: Path, data_sha256: str) -> None:
    """Say again that the run is of the data it had before: nothing was learned from others."""
    config = {**_begun(folder), "data_sha256": data_sha256}
    (folder / CONFIG).write_text(json.dumps(config, indent=1) + "\n", encoding="utf-8")


def finish(folder: Path, checkpoint: Checkpoint) -> None:
    """Leave a copy of the card of what came of the run."""
    shutil.copyfile(checkpoint.folder / CARD, folder / CARD)


def _begun(folder: Path) -> dict[str, object]:
    path = folder / CONFIG
    if not path.exists():
        return {}
    try:
        return dict(json.loads(path.read_text(encoding="utf-8")))
    except (ValueError, TypeError) as error:
        raise DataError(f"{path} does not say what the run was begun with ({error}); choose another --id") from error


def _compare(begun: Mapping[str, object], now: Mapping[str, object], config: Optimisation, on_purpose: bool) -> None:
    """Refuse what is not to be gone on with."""
    changes = {entry.name: entry.metadata["change"] for entry in dataclasses.fields(config)} | _CHANGES
    other = [name for name in now if name in begun and begun[name] != now[name]]
    never = [name for name in other if changes.get(name) == "never"]
    asked = [name for name in other if changes.get(name) == "asked"]
    if never:
        raise DataError(f"{_told(begun, now, never)}; train that under another --id")
    if asked and not on_purpose:
        raise DataError(
            f"{_told(begun, now, asked)}; choose another --id, or go on with what it has learned by --go-on"
        )


def _told(begun: Mapping[str, object], now: Mapping[str, object], names: Sequence[str]) -> str:
    differences = [
        f"{_WORDS.get(name, name.replace('_', '-'))} {_short(begun[name])}, not {_short(now[name])}" for name in names
    ]
    return f"this run was begun with {'; '.join(differences)}"


def _short(value: object) -> str:
    """A value as typed; of a hash its beginning."""
    text = {True: "yes", False: "no"}[value] if isinstance(value, bool) else str(value)
    return f"{text[:12]}…" if len(text) == 64 else text or "none"
