"""Trained agents on disk: one folder with a card and its files, read without running anything from it.

    <id with @ as ->/card.json            who this is, how it was made, how good it is; a strict schema
                    policy.onnx           what plays (onnxruntime)
                    policy.safetensors    the same weights, for other tools
                    dynamics.onnx ...     for BASS: the simulator
                    value.onnx            for BASS with `score` value: what will come of a state

The card names every file with its size and SHA-256; whatever does not match is refused. There are no pickles.
Folders are found by listing, never by joining a path from what somebody typed.
"""

import contextlib
import hashlib
import json
import math
import re
import shutil
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator

from movingout.agents.checkpoint.onnx_validation import check_onnx
from movingout.agents.checkpoint.policy_spec import KindName, PolicySpec
from movingout.agents.errors import CheckpointError

SHIPPED = Path(__file__).resolve().parents[1] / "checkpoints"
MODEL_ROOTS = (Path("data") / "models", SHIPPED)
"""Where checkpoints are looked for: what the user trained, then what comes with the project."""
CARD = "card.json"
MAX_CARD_BYTES = 1 << 20
MAX_FILE_BYTES = 256 << 20
FileName = Annotated[str, Field(pattern=r"^[a-z][a-z0-9_-]{0,31}\.(onnx|safetensors|json)$")]
"""Of a file beside the card; which there are is the business of the agent kind."""

_Line = Annotated[str, Field(max_length=400)]
_Sha256 = Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]
_WORD = "[a-z0-9][a-z0-9._-]{0,47}"
_AgentId = Annotated[str, Field(pattern=f"^{_WORD}(@{_WORD})?$")]
MAX_NAME = 60
MAX_POPULATION = 300  # characters; a description has it in it


class _StrictModel(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class FileEntry(_StrictModel):
    """One file of the folder."""

    name: FileName
    bytes: Annotated[int, Field(ge=1, le=MAX_FILE_BYTES)]
    sha256: _Sha256


class Score(_StrictModel):
    """One measured mean, with its standard error over n episodes."""

    mean: float
    stderr: Annotated[float, Field(ge=0.0)]
    n: Annotated[int, Field(ge=1)]


class Training(_StrictModel):
    """Where the weights of a network come from."""

    preset: _Line
    data_sha256: _Sha256
    population: _Line
    episodes: Annotated[int, Field(ge=0)]
    windows: Annotated[int, Field(ge=0)]  # rows it learned from: windows of a policy, ticks of a simulator, states
    updates: Annotated[int, Field(ge=0)]  # in all, those before it was gone on with included
    seed: int
    created: _Line  # ISO date


Combine = Literal["independent", "product"]
SelectionScore = Literal["nfd", "nfd+ac", "value"]
DynamicsKind = Literal["vae", "gru"]


class SelectionSpec(_StrictModel):
    """How BASS chooses among candidates (paper, "Study on Action Sampling Times")."""

    own: Annotated[int, Field(ge=1, le=16)] = 4
    partner: Annotated[int, Field(ge=1, le=16)] = 4
    combine: Combine = "product"
    score: SelectionScore = "nfd"  # value: what is done, and what a network says will follow
    depth: Annotated[int, Field(ge=1, le=32)] = 8  # ticks to simulate


class DynamicsSpec(_StrictModel):
    """The shape of the learned simulator: two autoencoders around a latent step (paper, "BASS Details")."""

    kind: DynamicsKind = "vae"
    width: Annotated[int, Field(ge=4, le=2048)] = 128
    latent: Annotated[int, Field(ge=2, le=512)] = 32
    residual: bool = True  # decode the change of the state instead of the state
    rigid: bool = False  # items move as one body with who holds them, instead of being predicted
    grasping: bool = False  # what a press does is calculated, instead of being predicted


class ValueSpec(_StrictModel):
    """What the value network of BASS says: the progress that is still to come, less the later it comes."""

    width: Annotated[int, Field(ge=4, le=2048)] = 256
    members: Annotated[int, Field(ge=1, le=16)] = 1  # networks whose mean it is
    discount: Annotated[float, Field(gt=0.0, lt=1.0)] = 0.98  # per tick


class Card(_StrictModel):
    """card.json."""

    schema_version: Literal[1]
    id: _AgentId
    name: Annotated[str, Field(min_length=1, max_length=MAX_NAME)]
    description: _Line
    kind: KindName
    maps: Annotated[tuple[_Line, ...], Field(min_length=1, max_length=64)]
    policy: PolicySpec
    dynamics: DynamicsSpec | None = None
    selection: SelectionSpec | None = None
    value: ValueSpec | None = None
    training: Training  # of the policy, with BASS that of the base; of the other two, which older cards do not say:
    dynamics_training: Training | None = None
    value_training: Training | None = None
    scores: dict[Annotated[str, Field(max_length=60)], Score] = {}
    files: Annotated[tuple[FileEntry, ...], Field(min_length=1, max_length=8)]

    @field_validator("scores")
    @classmethod
    def _finite(cls, scores: dict[str, Score]) -> dict[str, Score]:
        if not all(math.isfinite(score.mean) and math.isfinite(score.stderr) for score in scores.values()):
            raise ValueError("scores are finite numbers")
        return scores


@dataclass(frozen=True, slots=True)
class Checkpoint:
    """A folder whose card has been read; its files are checked when they are."""

    folder: Path
    card: Card
    sha256: str  # of the card, and so of everything it names

    def read(self, name: FileName) -> bytes:
        """The contents of a file, as the card promises them. Raises CheckpointError when they are not."""
        entry = next((entry for entry in self.card.files if entry.name == name), None)
        if entry is None:
            raise CheckpointError(f"checkpoint {self.card.id} has no {name}")
        data = _read_capped(self.folder / name, entry.bytes)
        if len(data) != entry.bytes or hashlib.sha256(data).hexdigest() != entry.sha256:
            raise CheckpointError(
                f"{name} of checkpoint {self.card.id} is not the file its card describes; copy it anew"
            )
        if name.endswith(".onnx"):
            check_onnx(data)
        return data


def folder_name(agent_id: str) -> str:
    """The folder of an id: `dp@all` lies in `dp-all`."""
    return agent_id.replace("@", "-")


def check_labels(agent_id: str, name: str, population: str) -> None:
    """Raises CheckpointError, in a sentence, for what the card of an agent that is to be trained cannot say."""
    if not re.fullmatch(f"{_WORD}@{_WORD}", agent_id):
        raise CheckpointError(
            f"{agent_id!r} is no id of a trained agent; it is two words of a-z, 0-9, '.', '_' and '-' with @ between, "
            "such as dp@mine"
        )
    for what, text, most in (("name", name, MAX_NAME), ("population", population, MAX_POPULATION)):
        if len(text) > most:
            raise CheckpointError(f"the {what} has {len(text)} characters; {most} is the most")


def read_checkpoint(folder: Path) -> Checkpoint:
    """Read a folder's card. Raises CheckpointError, in a sentence, when it is not one of ours."""
    data = _read_capped(folder / CARD, MAX_CARD_BYTES)
    try:
        card = Card.model_validate_json(data)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"]) or "the file"
        raise CheckpointError(f"{folder.name}/{CARD}: {where}: {first['msg']}") from error
    if folder.name != folder_name(card.id):
        raise CheckpointError(f"checkpoint {card.id} lies in folder {folder.name}, not in {folder_name(card.id)}")
    return Checkpoint(folder, card, hashlib.sha256(data).hexdigest())


def checkpoint_folders(*roots: Path) -> Iterator[Path]:
    """The folders that have a card, in the order of `roots` and names; of equal names the first. No links."""
    seen: set[str] = set()
    for root in filter(Path.is_dir, roots):
        for folder in sorted(root.iterdir()):
            if folder.name not in seen and folder.name[0] != "." and not folder.is_symlink() and _has_card(folder):
                seen.add(folder.name)
                yield folder


def find_checkpoint(agent_id: str, *roots: Path) -> Checkpoint:
    """The checkpoint of an id, the first of `roots` that has it. Raises CheckpointError when none does."""
    for folder in checkpoint_folders(*roots):
        if folder.name == folder_name(agent_id):
            found = read_checkpoint(folder)
            if found.card.id == agent_id:  # two ids may have one folder: dp-b@mine and dp@b-mine
                return found
    known = ", ".join(checkpoint.card.id for checkpoint in readable_checkpoints(*roots)) or "none"
    raise CheckpointError(f"no checkpoint {agent_id!r}; there are: {known}")


def fingerprint(agent_id: str) -> str:
    """The SHA-256 of the card of an agent, and so of its weights; empty for one without a checkpoint."""
    card = card_bytes(agent_id)
    return hashlib.sha256(card).hexdigest() if card else ""


def card_bytes(agent_id: str) -> bytes:
    """The card of an agent as it is now; empty for one without a checkpoint, or when it cannot be read any more."""
    reference = agent_id.partition(":")[0]
    if "@" not in reference:
        return b""
    try:
        return (find_checkpoint(reference, *MODEL_ROOTS).folder / CARD).read_bytes()
    except (CheckpointError, OSError):
        return b""


def readable_checkpoints(*roots: Path) -> Iterator[Checkpoint]:
    """Those whose card can be read, in the order of `checkpoint_folders`; `damage` has the others."""
    for folder in checkpoint_folders(*roots):
        with contextlib.suppress(CheckpointError):
            yield read_checkpoint(folder)


def damage(*roots: Path) -> list[str]:
    """What is wrong with each card that cannot be read, in a sentence that names the file."""
    sentences = []
    for folder in checkpoint_folders(*roots):
        try:
            read_checkpoint(folder)
        except CheckpointError as error:
            sentences.append(str(error))
    return sentences


def write_checkpoint(folder: Path, card: Mapping[str, object], files: Mapping[FileName, bytes]) -> Checkpoint:
    """Write a folder, wholly or not at all. `card` is a Card without `files` as a mapping.

    Raises CheckpointError when another agent lies there, or the disk does not take it.
    """
    entries = [
        {"name": name, "bytes": len(data), "sha256": hashlib.sha256(data).hexdigest()} for name, data in files.items()
    ]
    whole = Card.model_validate_json(json.dumps({**card, "files": entries}))
    check_room(folder, whole.id)
    draft, before = (folder.with_name(f".{folder.name}.{word}") for word in ("draft", "before"))
    try:
        _bring_back(before, folder)
        shutil.rmtree(draft, ignore_errors=True)
        draft.mkdir(parents=True)
        for name, data in files.items():
            (draft / name).write_bytes(data)
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


def _bring_back(before: Path, folder: Path) -> None:
    """Put an agent back whose successor did not come; one whose successor came is removed."""
    if before.exists() and not folder.exists():
        before.replace(folder)
    shutil.rmtree(before, ignore_errors=True)


def check_room(folder: Path, agent_id: str) -> None:
    """Raises CheckpointError when an agent of another id lies in the folder, which two ids may share."""
    there = next((one.card.id for one in readable_checkpoints(folder.parent) if one.folder == folder), agent_id)
    if there != agent_id:
        raise CheckpointError(f"{folder} is the folder of {there}; choose another id than {agent_id}")


def rescored(checkpoint: Checkpoint, scores: Mapping[str, Score]) -> Checkpoint:
    """The same checkpoint with measured scores in its card."""
    card = checkpoint.card.model_copy(update={"scores": dict(scores)})
    draft = checkpoint.folder / f".{CARD}.draft"
    try:
        draft.write_text(card.model_dump_json(indent=1) + "\n", encoding="utf-8")
        draft.replace(checkpoint.folder / CARD)
    except OSError as error:
        raise CheckpointError(f"cannot write the card of {card.id}: {error.strerror or error}") from error
    return read_checkpoint(checkpoint.folder)


def _read_capped(path: Path, limit: int) -> bytes:
    """The bytes of a plain file of at most `limit` bytes."""
    try:
        if path.is_symlink() or not path.is_file():
            raise CheckpointError(f"there is no plain file {path.name} in checkpoint folder {path.parent.name}")
        if path.stat().st_size > limit:
            raise CheckpointError(f"{path.name} in {path.parent.name} is larger than the {limit} bytes it may have")
        return path.read_bytes()
    except OSError as error:
        raise CheckpointError(f"cannot read {path.name} in {path.parent.name}: {error.strerror or error}") from error


def _has_card(folder: Path) -> bool:
    """Whether there is a card; also where nobody may look, so that reading it says so."""
    try:
        return (folder / CARD).is_file()
    except OSError:
        return True
