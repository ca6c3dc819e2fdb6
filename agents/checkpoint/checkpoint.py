"""Trained agents on disk: one folder with a card and its files, read without running anything from it.

    <id with @ as ->/card.json            identity, origin and scores; a strict schema
                    policy.onnx           the network that plays (onnxruntime)
                    policy.safetensors    the same weights, for other tools; not in the wheel
                    dynamics.onnx ...     BASS: the simulator
                    value.onnx            BASS with `score` value: the value network

The card names every file with its size and SHA-256; a file that does not match is refused. Nothing is unpickled.
Folders are found by listing, never by joining a path from user input.
"""

import contextlib
import hashlib
import json
import os
import re
import shutil
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from pydantic import ValidationError

from movingout.agents.adapters.option_files import file_fingerprint
from movingout.agents.around_others import acting_id
from movingout.agents.checkpoint.card import ID_WORD, MAX_NAME, MAX_POPULATION, Card, FileEntry, FileName, Score
from movingout.agents.checkpoint.onnx_interface import Shapes, onnx_interface
from movingout.agents.checkpoint.onnx_validation import check_onnx
from movingout.agents.errors import AgentError, CheckpointError
from movingout.maps.suggestion import probably_meant

SHIPPED = Path(__file__).resolve().parents[1] / "checkpoints"
MODELS_VARIABLE = "MOVINGOUT_MODELS"
CARD = "card.json"
MAX_CARD_BYTES = 1 << 20


@dataclass(frozen=True, slots=True)
class Checkpoint:
    """A folder whose card has been read. Files are verified when they are read."""

    folder: Path
    card: Card
    sha256: str  # of the card, and thereby of all files it names

    def has(self, name: FileName) -> bool:
        """Whether the card names this file and it is there; wheels leave out what only other tools read."""
        return any(entry.name == name and self._path(entry).is_file() for entry in self.card.files)

    def read(self, name: FileName) -> bytes:
        """The contents of a file. Raises CheckpointError when they do not match the card."""
        entry = next((entry for entry in self.card.files if entry.name == name), None)
        if entry is None:
            raise CheckpointError(f"checkpoint {self.card.id} has no {name}")
        path = self._path(entry)
        if entry.of and not path.is_file():
            raise CheckpointError(f"{self.card.id} has {name} in common with {entry.of}; copy that agent beside it")
        data = _read_capped(path, entry.bytes)
        if len(data) != entry.bytes or hashlib.sha256(data).hexdigest() != entry.sha256:
            raise CheckpointError(
                f"{name} of checkpoint {self.card.id} is not the file its card describes; copy it anew"
            )
        if name.endswith(".onnx"):
            check_onnx(data)
        return data

    def networks(self) -> dict[FileName, tuple[Shapes, Shapes]]:
        """The inputs and outputs of each ONNX file with their shapes, from the card or, of older ones, from the file.

        Raises CheckpointError as `read`.
        """
        return {
            entry.name: onnx_interface(self.read(entry.name))
            if entry.inputs is None or entry.outputs is None
            else (dict(entry.inputs), dict(entry.outputs))
            for entry in self.card.files
            if entry.name.endswith(".onnx")
        }

    def _path(self, entry: FileEntry) -> Path:
        return (self.folder.with_name(folder_name(entry.of)) if entry.of else self.folder) / entry.name


def model_roots() -> tuple[Path, ...]:
    """Where checkpoints are looked for: a folder that MOVINGOUT_MODELS names, your own, those that are shipped."""
    named = os.environ.get(MODELS_VARIABLE)
    return (*([Path(named)] if named else []), Path("data") / "models", SHIPPED)


def ships(agent_id: str) -> bool:
    """Whether an agent of this id comes with the package."""
    return any(checkpoint.card.id == agent_id for checkpoint in readable_checkpoints(SHIPPED))


def missing_models() -> str:
    """How the message about an unknown agent ends if MOVINGOUT_MODELS names no folder; else empty."""
    named = os.environ.get(MODELS_VARIABLE)
    return f"; {MODELS_VARIABLE} names {named}, which is no folder" if named and not Path(named).is_dir() else ""


def own_models() -> str:
    """The first of these folders, for a process with another working directory."""
    return str(model_roots()[0].resolve())


def folder_name(agent_id: str) -> str:
    """The folder name of an id: `dp-all` for `dp@all`."""
    return agent_id.replace("@", "-")


def check_labels(agent_id: str, name: str, population: str) -> None:
    """Raises CheckpointError for an id, name or population that a card cannot hold."""
    if not re.fullmatch(f"{ID_WORD}@{ID_WORD}", agent_id):
        raise CheckpointError(
            f"{agent_id!r} is no id of a trained agent; it is two words of a-z, 0-9, '.', '_' and '-' with @ between, "
            "such as dp@mine"
        )
    for what, text, most in (("name", name, MAX_NAME), ("population", population, MAX_POPULATION)):
        if len(text) > most:
            raise CheckpointError(f"the {what} has {len(text)} characters; {most} is the most")


def read_checkpoint(folder: Path) -> Checkpoint:
    """Read a folder's card. Raises CheckpointError when it is missing or invalid."""
    data = _read_capped(folder / CARD, MAX_CARD_BYTES)
    card = _card(data, folder)
    if folder.name != folder_name(card.id):
        raise CheckpointError(f"checkpoint {card.id} lies in folder {folder.name}, not in {folder_name(card.id)}")
    return Checkpoint(folder, card, hashlib.sha256(data).hexdigest())


def _card(data: bytes | str, folder: Path) -> Card:
    try:
        return Card.model_validate_json(data)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"]) or "the file"
        given = f", not {first['input']!r:.40}" if first["type"] == "literal_error" else ""
        raise CheckpointError(f"{folder.name}/{CARD}: {where}: {first['msg']}{given}") from error


def named_instead(path: Path) -> str:
    """What to name instead of the folder or a file of a checkpoint, as a sentence; empty for any other path."""
    try:
        folder = path if path.is_dir() else path.parent
        card = read_checkpoint(folder.resolve()).card
    except (CheckpointError, OSError):  # also what is too long to be a path
        return ""
    if path != folder and path.name != CARD and path.name not in {entry.name for entry in card.files if not entry.of}:
        return ""
    what = "the folder" if path == folder else "a file"
    sentence = f"{path} is {what} of the trained agent {card.id}, which is named by its id: {card.id}"
    roots = [root.resolve() for root in model_roots()]
    if folder.resolve().parent in roots:
        return sentence
    return f"{sentence} (once {MODELS_VARIABLE}={folder.resolve().parent} is set, or the folder copied to data/models)"


def checkpoint_folders(*roots: Path) -> Iterator[Path]:
    """Folders with a card, sorted by root and name; the first of equal names. Symbolic links are skipped."""
    seen: set[str] = set()
    for root in filter(Path.is_dir, roots):
        for folder in sorted(root.iterdir()):
            if folder.name not in seen and folder.name[0] != "." and not folder.is_symlink() and _has_card(folder):
                seen.add(folder.name)
                yield folder


def find_checkpoint(agent_id: str, *roots: Path) -> Checkpoint:
    """The checkpoint of an id, from the first of `roots` that has it. Raises CheckpointError when none does."""
    if found := _found(agent_id, *roots):
        return found
    ids = [checkpoint.card.id for checkpoint in readable_checkpoints(*roots)]
    known, question = ", ".join(ids) or "none", probably_meant(agent_id, ids) or ";"
    raise CheckpointError(f"no checkpoint {agent_id!r}{question} there are: {known}{missing_models()}")


def card_of(agent_id: str) -> Card | None:
    """The card of an agent, whatever its options; None without a checkpoint, or with one that cannot be read."""
    reference = agent_id.strip().partition(":")[0]
    try:
        found = _found(reference, *model_roots()) if "@" in reference else None
    except CheckpointError:
        return None
    return found.card if found else None


def _found(agent_id: str, *roots: Path) -> Checkpoint | None:
    for folder in checkpoint_folders(*roots):
        if folder.name == folder_name(agent_id):
            found = read_checkpoint(folder)
            if found.card.id == agent_id:  # two ids may share a folder name: dp-b@mine and dp@b-mine
                return found
    return None


def fingerprint(agent_id: str) -> str:
    """The SHA-256 of an agent's card, and thereby of its weights, or of the files that its options name; else empty.

    Of an agent around another one, that of the agent inside: after another training it plays otherwise too.
    """
    card = card_bytes(agent_id)
    return hashlib.sha256(card).hexdigest() if card else file_fingerprint(_acting_id(agent_id))


def card_bytes(agent_id: str) -> bytes:
    """The card of the agent that decides, as it is now; empty without one, or when it can no longer be read."""
    reference = _acting_id(agent_id).strip().partition(":")[0]
    if "@" not in reference:
        return b""
    try:
        found = _found(reference, *model_roots())
        return (found.folder / CARD).read_bytes() if found else b""
    except (CheckpointError, OSError):
        return b""


def _acting_id(agent_id: str) -> str:
    try:
        return acting_id(agent_id)
    except AgentError:  # unknown options are refused when the agent is loaded
        return agent_id


def readable_checkpoints(*roots: Path) -> Iterator[Checkpoint]:
    """Checkpoints whose card can be read, in the order of `checkpoint_folders`; `damage` lists the others."""
    for folder in checkpoint_folders(*roots):
        with contextlib.suppress(CheckpointError):
            yield read_checkpoint(folder)


def damage(*roots: Path) -> list[str]:
    """One sentence per unreadable card, naming the file and the fault."""
    sentences = []
    for folder in checkpoint_folders(*roots):
        try:
            read_checkpoint(folder)
        except CheckpointError as error:
            sentences.append(str(error))
    return sentences


def write_checkpoint(
    folder: Path, card: Mapping[str, object], files: Mapping[FileName, bytes], share: bool = False
) -> Checkpoint:
    """Write a folder atomically. `card` is a Card as a mapping, without `files`.

    With `share`, a file that an agent beside it has already is named and not written.
    Raises CheckpointError when the card is invalid, the folder belongs to another agent, or cannot be written.
    """
    entries = [_entry(name, data) for name, data in files.items()]
    if share:
        entries = [{**entry, "of": _owner(entry, folder)} for entry in entries]
    whole = _card(json.dumps({**card, "files": entries}), folder)
    check_room(folder, whole.id)
    draft, before = (folder.with_name(f".{folder.name}.{word}") for word in ("draft", "before"))
    try:
        _bring_back(before, folder)
        shutil.rmtree(draft, ignore_errors=True)
        draft.mkdir(parents=True)
        for entry in whole.files:
            if entry.of is None:
                (draft / entry.name).write_bytes(files[entry.name])
        (draft / CARD).write_text(whole.model_dump_json(indent=1) + "\n", encoding="utf-8")
        if folder.exists():
            folder.replace(before)
        draft.replace(folder)
        shutil.rmtree(before, ignore_errors=True)
    except OSError as error:
        shutil.rmtree(draft, ignore_errors=True)
        _bring_back(before, folder)
        raise CheckpointError(f"cannot write {folder}: {error.strerror or error}") from error
    return read_checkpoint(folder)


def _entry(name: FileName, data: bytes) -> dict[str, object]:
    about: dict[str, object] = {"name": name, "bytes": len(data), "sha256": hashlib.sha256(data).hexdigest()}
    if name.endswith(".onnx"):
        with contextlib.suppress(CheckpointError):  # a file that is no model is refused when it is loaded
            about["inputs"], about["outputs"] = onnx_interface(data)
    return about


def _owner(entry: Mapping[str, object], folder: Path) -> str | None:
    """The id of an agent beside `folder` that has a file of its own with this name and content."""
    wanted = (entry["name"], entry["bytes"], entry["sha256"], None)
    for checkpoint in readable_checkpoints(folder.parent):
        own = {(one.name, one.bytes, one.sha256, one.of) for one in checkpoint.card.files}
        if checkpoint.folder != folder and wanted in own:
            return checkpoint.card.id
    return None


def _bring_back(before: Path, folder: Path) -> None:
    """Restore the previous folder if no new one took its place; otherwise remove it."""
    if before.exists() and not folder.exists():
        before.replace(folder)
    shutil.rmtree(before, ignore_errors=True)


def check_room(folder: Path, agent_id: str) -> None:
    """Raises CheckpointError when the folder belongs to an agent with another id (two ids may share a folder name)."""
    there = next((one.card.id for one in readable_checkpoints(folder.parent) if one.folder == folder), agent_id)
    if there != agent_id:
        raise CheckpointError(f"{folder} is the folder of {there}; choose another id than {agent_id}")


def rescored(checkpoint: Checkpoint, scores: Mapping[str, Score]) -> Checkpoint:
    """The same checkpoint with these scores in its card. Raises CheckpointError."""
    card = checkpoint.card.model_copy(update={"scores": dict(scores)})
    draft = checkpoint.folder / f".{CARD}.draft"
    try:
        draft.write_text(card.model_dump_json(indent=1) + "\n", encoding="utf-8")
        draft.replace(checkpoint.folder / CARD)
    except OSError as error:
        raise CheckpointError(f"cannot write the card of {card.id}: {error.strerror or error}") from error
    return read_checkpoint(checkpoint.folder)


def _read_capped(path: Path, limit: int) -> bytes:
    """The bytes of a regular file of at most `limit` bytes."""
    try:
        if path.is_symlink() or not path.is_file():
            raise CheckpointError(f"there is no plain file {path.name} in checkpoint folder {path.parent.name}")
        if path.stat().st_size > limit:
            raise CheckpointError(f"{path.name} in {path.parent.name} is larger than the {limit} bytes it may have")
        return path.read_bytes()
    except OSError as error:
        raise CheckpointError(f"cannot read {path.name} in {path.parent.name}: {error.strerror or error}") from error


def _has_card(folder: Path) -> bool:
    """Whether there is a card; also true without permission to look, so that reading it reports the error."""
    try:
        return (folder / CARD).is_file()
    except OSError:
        return True
