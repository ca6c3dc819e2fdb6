"""The data of a training run: recordings, and episodes labelled by an expert."""

import hashlib
import json
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
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
    NAMELESS,
    SeatChoice,
    SeatSamples,
    Trajectory,
    data_hash,
    learned_seats,
    person,
    read_trajectory,
    recording_files,
    trajectory_samples,
)
from movingout.agents.errors import DataError
from movingout.agents.observation.features import FeatureSet
from movingout.agents.partners.families import are_for_tests, group, is_scripted_person, name_of
from movingout.agents.partners.identity import person_behind
from movingout.maps.suggestion import counted
from movingout.recordings.recorded_seat import is_ghost
from movingout.recordings.storage.copies import without_copies
from movingout.recordings.storage.study_rounds import counted_recordings
from movingout.world.observation import LAYOUTS

NAMED, AGENT, REPLAY = "participant", "agent", "replay"  # what those who are learned from count as in a card
NAMELESS_PEOPLE, NAMELESS_AGENTS = "nameless people", "nameless agents"


@dataclass(frozen=True, slots=True)
class TrainingData:
    """All recordings and corrections under the given paths."""

    files: list[Path]
    trajectories: list[Trajectory]
    corrections: list[Correction]
    uncounted: int = 0  # recordings that are left out, because their study does not count them
    copies: list[Path] = field(default_factory=list)  # likewise because they are copies of recordings that are there
    empty: list[Path] = field(default_factory=list)  # likewise because they have no tick to learn from
    learned: list[tuple[Path, Trajectory]] = field(
        default_factory=list
    )  # files with their episodes; tutorials have none

    @property
    def sha256(self) -> str:
        """Of all files."""
        return data_hash(self.files)

    @property
    def sha256_with_copies(self) -> str:
        """By which runs know the same data that were begun when copies were learned from, too."""
        return data_hash([*self.files, *self.copies])

    @property
    def episodes(self) -> list[Trajectory]:
        """All episodes, whoever acts in them."""
        return [*self.trajectories, *(one.trajectory for one in self.corrections)]

    @property
    def people(self) -> set[str]:
        """The people in all episodes."""
        return {name for trajectory in self.episodes for name in trajectory.people}

    @property
    def people_sha256(self) -> str:
        """Of who counts as whom in the seats of all episodes: of the same data, others are held out by another one."""
        pairs = sorted((one.whose(0), one.whose(1)) for one in self.episodes)
        return hashlib.sha256(json.dumps(pairs).encode()).hexdigest()

    def population(self, people: Collection[str]) -> str:
        """How many these are; agents, and programs that took part in a rehearsal, are not to pass for people.

        Scripted people count as participants. Of those without a name nobody knows how many they are: their episodes
        are counted.
        """
        simulated = {trajectory.simulated for trajectory in self.episodes}
        known = {one.whose(seat) for one in self.episodes for seat in (0, 1) if one.is_known_person(seat)}
        sorts = Counter(_sort(name, name in known) for name in people)
        participant = "simulated participant" if simulated == {True} else "participant"
        words = [
            counted(n, participant) if (n := sorts[NAMED]) else "",
            counted(n, "agent") if (n := sorts[AGENT]) else "",
            counted(n, "replay") if (n := sorts[REPLAY]) else "",
            f"people without a name ({counted(n, 'episode')})" if (n := sorts[NAMELESS_PEOPLE]) else "",
            f"agents without a name ({counted(n, 'episode')})" if (n := sorts[NAMELESS_AGENTS]) else "",
        ]
        said = " and ".join(filter(None, words)) or "agents alone"
        return said + (", some of them simulated" if simulated == {True, False} else "")

    def counts_otherwise(self, seats: SeatChoice | None) -> bool:
        """Whether somebody counts as somebody else than for earlier versions.

        For these a program beside a person was somebody of its own, and all people without a name were one. `seats` are
        those learned from, None where whole episodes are held out. Labels keep who counts as whom.
        """
        if seats is None:
            return any(one.people != _people_before(one) for one in self.trajectories)
        return any(
            one.whose(seat) != _called_before(person(one.participants[seat]))
            for one in self.trajectories
            for seat in learned_seats(one, seats)
        )

    @property
    def learns_from_tests(self) -> bool:
        """Whether scripted people who are for tests play in any episode; somebody at a keyboard may have their name."""
        seats = {seat for one in self.episodes for seat in zip(one.participants, one.kinds, strict=True)}
        named = {name.removeprefix("expert:") for name, kind in seats if kind != "human"}
        return are_for_tests(named.union(*(one.agent_ids for one in self.episodes)))

    def left_out(self, seats: SeatChoice) -> int:
        """Number of seats of the recordings that are not learned from."""
        return sum(2 - len(learned_seats(trajectory, seats)) for trajectory in self.trajectories)

    def check_seen(self, layout: str) -> None:
        """Raises DataError for episodes on maps with more of something than a layout has room for."""
        if why := LAYOUTS[layout].refusal((file, trajectory.map) for file, trajectory in self.learned):
            raise DataError(why)

    def pieces(self, spec: PolicySpec, seats: SeatChoice) -> Iterator[SeatSamples]:
        """Training samples of a policy: the chosen seats of recordings, and the expert's labels.

        Raises DataError for labels that the policy cannot learn.
        """
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


def read_training_data(places: list[Path], without: Iterable[str] = ()) -> TrainingData:
    """Read all files but copies, and those of episodes that a study does not count or somebody of `without` plays in.

    `without` has names of partners as `group` takes them. Raises DataError when no file is left, or when nobody whom
    one of them names plays in any: then it is wrong. RecordingError for the database of a study that cannot be read;
    AgentError as `group`.
    """
    if not places:
        raise DataError("name recordings to learn from, or folders of them; `movingout demos label` makes some")
    avoided = {name: _called(name) for name in without}
    found_files = recording_files(places, (".mcap", SUFFIX))
    counting = counted_recordings(found_files)
    if not counting:
        raise DataError(f"none of {counted(len(found_files), 'recording')} counts: their study leaves them out")
    files = without_copies(counting)
    copies = [file for file in counting if file not in set(files)]
    kept = TrainingData([], [], [], len(found_files) - len(counting), copies)
    met = {name for file in files for name in _read(file, kept, avoided)}
    _check_left_out([name for name in avoided if name not in met], len(files))
    if not kept.files:
        why = "somebody who is to be left out plays in every episode" if met else "no episode has a tick"
        raise DataError(f"{why}; name other recordings")
    return kept


def _read(file: Path, kept: TrainingData, avoided: Mapping[str, set[str]]) -> list[str]:
    """Add a file to what is kept, unless somebody who is to be avoided plays in it: returns by which of the names."""
    correction = load_correction(file) if file.name.endswith(SUFFIX) else None
    found = correction.trajectory if correction else read_trajectory(file)
    players = _players(found) if found else frozenset()
    if met := [name for name, calls in avoided.items() if calls & players]:
        return met
    if found and not found.ticks:  # an agent failed at once, or labels on a map that was delivered from the start
        kept.empty.append(file)
        return []
    kept.files.append(file)
    if found:
        kept.learned.append((file, found))
    if correction:
        kept.corrections.append(correction)
    elif found:
        kept.trajectories.append(found)
    return []


def _sort(name: str, is_known: bool) -> str:
    """What somebody counts as in a card; `is_known` is whether a person is at their seat."""
    if name.startswith(NAMELESS):
        return NAMELESS_PEOPLE if is_known else NAMELESS_AGENTS
    if is_known or is_scripted_person(name.removeprefix("expert:")):
        return NAMED
    return REPLAY if is_ghost(name) else AGENT


def _people_before(trajectory: Trajectory) -> frozenset[str]:
    """The people in an episode, as for earlier versions."""
    return frozenset(_called_before(name) for name in trajectory.names if "@" not in name)


def _called_before(name: str) -> str:
    """As who somebody counted for earlier versions: all without a name as one."""
    return "" if name.startswith(NAMELESS) else name


def _called(name: str) -> set[str]:
    """What the partners of a name are called in episodes: by their family, by a list, by a match, or by their id."""
    return {
        called
        for one in group(name)
        for called in (one.name, name_of(one.agent_id), person(one.agent_id), one.agent_id)
    }


def _players(trajectory: Trajectory) -> frozenset[str]:
    """Who plays, by every name that is known; somebody with late hands or noise is still the same."""
    named = trajectory.names | trajectory.agent_ids
    return named | {person_behind(name) for name in named}


def _check_left_out(unmet: list[str], episodes: int) -> None:
    """Raises DataError for names that leave nothing out: a slip would let those in who were not to be learned from."""
    if unmet:
        words = " or ".join(f"--without {name}" for name in unmet)
        raise DataError(
            f"nobody named by {words} plays in any of these {counted(episodes, 'episode')}; correct the name or leave "
            "it out"
        )
