"""The data of a training run: recordings, and episodes labelled by an expert."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

from movingout.agents.bass.recombination import LearnedPart
from movingout.agents.checkpoint.policy_spec import PolicySpec
from movingout.agents.data.corrections import (
    SUFFIX,
    Correction,
    correction_samples,
    expert_stretches,
    load_correction,
    partner_samples,
)
from movingout.agents.data.dataset import (
    SeatChoice,
    SeatSamples,
    Trajectory,
    data_hash,
    learned_seats,
    person,
    read_trajectories,
    recording_files,
    trajectory_samples,
)
from movingout.agents.errors import DataError
from movingout.agents.observation.features import FeatureSet
from movingout.agents.partners.families import FamilyMember
from movingout.maps.suggestion import counted
from movingout.recordings.storage.study_rounds import counted_recordings


@dataclass(frozen=True, slots=True)
class TrainingData:
    """All recordings and corrections under the given paths."""

    files: list[Path]
    trajectories: list[Trajectory]
    corrections: list[Correction]
    uncounted: int = 0  # recordings that are left out, because their study does not count them

    @property
    def sha256(self) -> str:
        """Of all files."""
        return data_hash(self.files)

    @property
    def episodes(self) -> list[Trajectory]:
        """All episodes, whoever acts in them."""
        return [*self.trajectories, *(one.trajectory for one in self.corrections)]

    @property
    def people(self) -> set[str]:
        """The people in all episodes."""
        return {name for trajectory in self.episodes for name in trajectory.people}

    def left_out(self, seats: SeatChoice) -> int:
        """Number of seats of the recordings that are not learned from."""
        return sum(2 - len(learned_seats(trajectory, seats)) for trajectory in self.trajectories)

    def pieces(self, spec: PolicySpec, seats: SeatChoice) -> Iterator[SeatSamples]:
        """Training samples of a policy: the chosen seats of recordings, and the expert's labels."""
        if self.corrections and spec.grasp != "hold":
            raise DataError("an expert's labels say which hold level it wants; train with --grasp hold")
        seen = FeatureSet.of(spec)
        recorded = trajectory_samples(self.trajectories, seen, spec.grasp, seats)
        return chain(recorded, correction_samples(self.corrections, seen))

    def partners(self, spec: PolicySpec, seats: SeatChoice) -> Iterator[SeatSamples]:
        """Whole episodes of those who play: the chosen seats of recordings, and the expert's partners."""
        seen = FeatureSet.of(spec)
        recorded = trajectory_samples(self.trajectories, seen, spec.grasp, seats)
        return chain(recorded, partner_samples(self.corrections, seen))

    def parts(self, spec: PolicySpec, seats: SeatChoice) -> list[LearnedPart]:
        """The same samples, in the form that recombination takes."""
        recorded = [
            LearnedPart(trajectory, seat, trajectory.targets(seat, spec.grasp), ((0, trajectory.ticks),))
            for trajectory in self.trajectories
            for seat in learned_seats(trajectory, seats)
        ]
        return recorded + [
            LearnedPart(one.trajectory, one.seat, one.labels, tuple(expert_stretches(one))) for one in self.corrections
        ]


def read_training_data(places: list[Path], without: Collection[FamilyMember] = ()) -> TrainingData:
    """Read all files but those of episodes that a study does not count, or in which somebody of `without` plays.

    Raises DataError when no file is left, or when nobody of `without` plays in any: then a name is wrong.
    RecordingError for the database of a study that cannot be read.
    """
    if not places:
        raise DataError("name recordings to learn from, or folders of them; `movingout demos label` makes some")
    avoided = {name for one in without for name in (one.name, person(one.agent_id))}
    found_files = recording_files(places, (".mcap", SUFFIX))
    files = counted_recordings(found_files)
    if not files:
        raise DataError(f"none of {counted(len(found_files), 'recording')} counts: their study leaves them out")
    kept = TrainingData([], [], [], len(found_files) - len(files))
    for file in files:
        correction = load_correction(file) if file.name.endswith(SUFFIX) else None
        found = [correction.trajectory] if correction else read_trajectories([file])
        if any(avoided & one.names for one in found):
            continue
        kept.files.append(file)
        if correction:
            kept.corrections.append(correction)
        else:
            kept.trajectories.extend(found)
    if not kept.files:
        raise DataError("somebody who is to be left out plays in every episode; name other recordings")
    if without and len(kept.files) == len(files):
        named = " or ".join(sorted(one.name for one in without)[:3])
        raise DataError(f"{named} plays in none of these {len(files)} episodes; nothing to leave out")
    return kept
