"""Episodes with an expert's labels: stored as .npz of plain arrays, and cut into stretches to learn from.

They are made by `agents.data.dagger`.
"""

import io
import json
import zlib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from zipfile import BadZipFile, ZipFile

import numpy as np
import numpy.typing as npt

from movingout.agents.data.dataset import SeatSamples, Singles, Trajectory
from movingout.agents.errors import DataError
from movingout.agents.observation.features import FeatureSet
from movingout.maps import map_from_json, map_to_json
from movingout.maps.files.output_file import draft_of
from movingout.recordings.errors import cannot
from movingout.recordings.file_format.records import ALWAYS_POSSIBLE, MOST_PER_BYTE

SHORTEST = 4  # ticks; shorter stretches are left out
LONGEST_REST = 15  # ticks of standing still to learn from; longer rests would dominate the data
SUFFIX = ".corrections.npz"
_UNREADABLE = (BadZipFile, zlib.error, EOFError, ValueError, KeyError, TypeError, MemoryError)
_ARRAYS = ("robot_poses", "robot_velocities", "held", "item_poses", "actions")


@dataclass(frozen=True, slots=True, eq=False)
class Correction:
    """An episode, the learner's seat, and the expert's labels for it."""

    trajectory: Trajectory
    seat: int
    labels: Singles  # (T, 5), the grasp as desired level
    taught: npt.NDArray[np.bool_]  # (T,) whether the expert acted, unperturbed


def correction_samples(corrections: Iterable[Correction], layout: str | FeatureSet) -> Iterator[SeatSamples]:
    """The samples of the stretches in which the expert acted."""
    seen = FeatureSet(layout) if isinstance(layout, str) else layout
    for one in corrections:
        features, angles = one.trajectory.features(one.seat, seen), one.trajectory.angles(one.seat, seen)
        for begin, end in expert_stretches(one):
            part = slice(begin, end)
            turned = None if angles is None else angles[part]
            yield SeatSamples(one.trajectory.participants[one.seat], features[part], one.labels[part], turned)


def partner_samples(corrections: Iterable[Correction], seen: FeatureSet) -> Iterator[SeatSamples]:
    """The other seat of each episode, whole: what the partner did beside learner and expert."""
    for one in corrections:
        seat, trajectory = 1 - one.seat, one.trajectory
        yield SeatSamples(
            trajectory.participants[seat],
            trajectory.features(seat, seen),
            trajectory.targets(seat, "hold"),
            trajectory.angles(seat, seen),
        )


def expert_stretches(one: Correction) -> Iterator[tuple[int, int]]:
    """(first, last + 1) of each sufficiently long run of ticks to learn from."""
    resting = 0
    taught = one.taught.copy()
    stays = np.diff(one.labels[:, 4], prepend=one.labels[:1, 4]) == 0.0  # letting go ends a rest
    for tick, rests in enumerate((one.labels[:, 0] == 0.0) & stays):
        resting = resting + 1 if rests else 0
        taught[tick] &= resting <= LONGEST_REST
    edges = np.flatnonzero(np.diff(np.concatenate(([False], taught, [False])).astype(np.int8)))
    for begin, end in edges.reshape(-1, 2).tolist():
        if end - begin >= SHORTEST:
            yield begin, end


def save_correction(path: Path, correction: Correction, recipe: Mapping[str, object] | None = None) -> None:
    """Write one file, atomically, with what it was made by. Raises RecordingError when it cannot be written."""
    trajectory = correction.trajectory
    about: dict[str, Any] = {"map": map_to_json(trajectory.map), "participants": trajectory.participants}
    about |= {"seat": correction.seat} | ({"recipe": dict(recipe)} if recipe else {})
    data = io.BytesIO()
    arrays = {name: getattr(trajectory, name) for name in _ARRAYS}
    arrays |= {"labels": correction.labels, "taught": correction.taught, "about": np.array(json.dumps(about))}
    np.savez_compressed(data, allow_pickle=False, **arrays)
    try:
        with draft_of(path) as draft:
            draft.write_bytes(data.getvalue())
    except OSError as error:
        raise cannot("write", path, error) from error


def read_about(path: Path) -> dict[str, Any]:
    """What a file says beside its arrays: map, participants, seat, recipe. Raises DataError for anything else."""
    try:
        _check_size(path)
        with np.load(path, allow_pickle=False) as file:
            return dict(json.loads(str(file["about"])))
    except (OSError, *_UNREADABLE) as error:
        raise DataError(f"{path} is not a file of corrections: {error}") from error


def load_correction(path: Path) -> Correction:
    """Read one file. Raises DataError for anything else."""
    try:
        _check_size(path)
        with np.load(path, allow_pickle=False) as file:
            about = json.loads(str(file["about"]))
            arrays = {name: file[name] for name in _ARRAYS}
            labels, taught = file["labels"], file["taught"]
            if not len(arrays["actions"]):  # on a map that was delivered from the start
                labels = labels.reshape(-1, 5)
            blue, red = about["participants"]
            ids = frozenset(filter(None, [about.get("recipe", {}).get("partner")]))
            trajectory = Trajectory(map_from_json(about["map"]), (blue, red), **arrays, agent_ids=ids)
            seat = int(about["seat"])
    except (OSError, *_UNREADABLE) as error:
        raise DataError(f"{path} is not a file of corrections: {error}") from error
    if labels.shape != (trajectory.ticks, 5) or taught.shape != (trajectory.ticks,) or seat not in (0, 1):
        raise DataError(f"{path}: labels of shape {labels.shape} for {trajectory.ticks} ticks; create the file again")
    return Correction(trajectory, seat, labels, taught)


def _check_size(path: Path) -> None:
    """Raises ValueError for a file of a few bytes that would fill the memory."""
    with ZipFile(path) as archive:
        unpacked = sum(entry.file_size for entry in archive.infolist())
    if unpacked > ALWAYS_POSSIBLE + MOST_PER_BYTE * path.stat().st_size:
        raise ValueError("its arrays would take more memory than any episode")
