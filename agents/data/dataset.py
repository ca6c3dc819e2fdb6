"""Recordings as training windows. Every episode is encoded once, by the code that also plays live; batches only gather.

A window is one seat at one tick: the observations up to it and the actions from it on. It never crosses the ends of its
episode: the first observation is repeated backwards and the last action forwards.
"""

import hashlib
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from movingout.agents.checkpoint.policy_spec import Grasp
from movingout.agents.errors import DataError
from movingout.agents.grasp_encoding import effective_presses, hold_levels
from movingout.agents.observation.features import Bytes, FeatureSet
from movingout.maps import MapSpec
from movingout.maps.spec import SEAT_COLOURS
from movingout.recordings import Episode, EpisodeHeader, read_episode
from movingout.recordings.episode import SeatKind, is_person
from movingout.recordings.errors import with_folder
from movingout.recordings.recorded_seat import is_ghost
from movingout.world.action import turned
from movingout.world.state import Floats, Ints

Singles = npt.NDArray[np.float32]
Indices = npt.NDArray[np.int64]

NAMELESS = "nameless:"  # before the id of an episode: those in it without a name, who count as somebody of their own


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """An episode of T ticks as arrays."""

    map: MapSpec
    participants: tuple[str, str]  # in blue and red; see `NAMELESS`
    robot_poses: Floats  # (T + 1, 2, 3)
    robot_velocities: Floats  # (T + 1, 2, 3)
    held: Ints  # (T + 1, 2)
    item_poses: Floats  # (T + 1, N, 3)
    actions: Floats  # (T, 2, 3) world actions: distance, heading, toggle
    kinds: tuple[SeatKind, SeatKind] = ("agent", "agent")  # of blue and red
    simulated: bool = False  # in a rehearsal of a study: its participants were programs
    agent_ids: frozenset[str] = frozenset()  # of those who play under a shorter name, where the file says them

    @property
    def ticks(self) -> int:
        return len(self.actions)

    @property
    def state_arrays(self) -> tuple[Floats, Floats, Ints, Floats]:
        """Robot poses, robot velocities, held items and item poses, T + 1 rows each."""
        return self.robot_poses, self.robot_velocities, self.held, self.item_poses

    @property
    def names(self) -> frozenset[str]:
        """Who plays; an expert beside a person counts as that person."""
        return frozenset(person(name).removeprefix("expert:") for name in self.participants)

    @property
    def people(self) -> frozenset[str]:
        """The people in the episode, without programs beside them; of programs alone, all but trained agents."""
        if self.is_known_person(0) or self.is_known_person(1):
            return frozenset(map(self.whose, (0, 1)))
        return frozenset(name for name in self.names if "@" not in name and not is_ghost(name))

    def whose(self, seat: int) -> str:
        """Who a seat counts as where training and validation share nobody: a program beside a person as that person."""
        beside = self.is_known_person(1 - seat) and not self.is_known_person(seat)
        return person(self.participants[1 - seat if beside else seat])

    def is_known_person(self, seat: int) -> bool:
        """Whether a person plays, or is replayed and named: `ghost:EPISODE#red` may have been an agent."""
        name = self.participants[seat]
        return is_person(self.kinds[seat]) and (self.kinds[seat] == "human" or not ("@" in name or is_ghost(name)))

    def features(self, seat: int, layout: str | FeatureSet) -> Singles | Bytes:
        """Observations (T, D) of `seat` before each tick, in a layout or with memory."""
        whole = FeatureSet(layout) if isinstance(layout, str) else layout
        states = self.robot_poses[:-1], self.robot_velocities[:-1], self.held[:-1], self.item_poses[:-1]
        return whole.of_episode(self.map, states, seat)

    def angles(self, seat: int, seen: FeatureSet) -> Singles | None:
        """The angles (T,) of `seat` before each tick, where the features are in its own frame."""
        return self.robot_poses[:-1, seat, 2].astype(np.float32) if seen.own_frame else None

    def targets(self, seat: int, grasp: Grasp) -> Singles:
        """Actions (T, 5) of `seat` in each tick, see `policy_spec.ACTION_WIDTH`."""
        yes = (hold_levels if grasp == "hold" else effective_presses)(self.held)[:, seat]
        heading = self.actions[:, seat, 1]
        columns = (
            np.clip(self.actions[:, seat, 0], -1.0, 1.0),
            np.cos(heading),
            np.sin(heading),
            np.where(yes, -1.0, 1.0),
            np.where(yes, 1.0, -1.0),
        )
        return np.stack(columns, axis=1).astype(np.float32)


def person(name: str) -> str:
    """The person behind a seat's name: `A01` for `person:name=A01`, as matches call the `A01` of demonstrations."""
    kind, _, options = name.partition(":")
    given = dict(option.partition("=")[::2] for option in options.split(","))
    return given.get("name", name) if kind == "person" else name


def trajectory_of(episode: Episode) -> Trajectory:
    """A recording as arrays."""
    states = episode.states
    return Trajectory(
        map=episode.header.map,
        participants=_participants(episode.header),
        robot_poses=np.array([state.robot_poses for state in states]),
        robot_velocities=np.array([state.robot_velocities for state in states]),
        held=np.array([state.held for state in states]),
        item_poses=np.array([state.item_poses for state in states]),
        actions=episode.actions,
        kinds=(episode.header.seats[0].kind, episode.header.seats[1].kind),
        simulated=episode.header.simulated,
        agent_ids=_agent_ids(episode.header),
    )


def _participants(header: EpisodeHeader) -> tuple[str, str]:
    blue, red = (seat.name or f"{NAMELESS}{header.episode_id}" for seat in header.seats)
    return blue, red


def _agent_ids(header: EpisodeHeader) -> frozenset[str]:
    """Demonstrations name their players, and keep the ids beside them."""
    given = header.study if header.source == "scripted" else {}
    return frozenset(given[colour] for colour in SEAT_COLOURS if colour in given)


SeatChoice = Literal["acting", "human", "all"]
"""Whose actions a policy learns: of all who act, of humans only, or of all seats including idle ones and ghosts."""


def has_person(kinds: Sequence[SeatKind]) -> bool:
    """Whether a person acts in an episode, given the kinds of its seats, and can be imitated.

    A replayed person does not act; whether training and tests share people is another question (`split.has_people`).
    """
    return "human" in kinds


def imitated_seats(kinds: Iterable[Sequence[SeatKind]]) -> SeatChoice:
    """As `train --seats`, given the kinds of the seats of each episode: people alone, where there are any."""
    return "human" if any(map(has_person, kinds)) else "acting"


def learned_seats(trajectory: Trajectory, choice: SeatChoice) -> tuple[int, ...]:
    """The seats of an episode that a policy learns from."""
    return tuple(seat for seat in (0, 1) if _is_learned(trajectory.kinds[seat], trajectory.participants[seat], choice))


def _is_learned(kind: SeatKind, name: str, choice: SeatChoice) -> bool:
    match choice:
        case "all":
            return True
        case "human":
            return kind == "human"
        case "acting":  # in a match, an idle seat is an agent of that name
            return kind not in ("idle", "ghost") and name.partition(":")[0] != "idle"


@dataclass(frozen=True, slots=True, eq=False)
class Windows:
    """Rows of many trajectories and their targets, concatenated; there may be more targets than rows.

    The index of a row identifies its window. Targets have headings of the arena; chunks have them relative to `angles`
    where features are in the own frame.
    """

    features: Singles | Bytes  # (M, D)
    targets: Singles  # (N, 5), N >= M
    starts: Indices  # (M,) first row of the row's trajectory
    first_targets: Indices  # (M,) index of the row's own target
    ends: Indices  # (M,) one past the last target of the row's trajectory
    people: npt.NDArray[np.int32]  # (M,) index into `names`
    names: tuple[str, ...]
    angles: Singles | None = None  # (M,) the own angle, in the own frame

    def __len__(self) -> int:
        return len(self.features)

    def observations(self, rows: Indices, history: int) -> Singles:
        """(B, history, D): the rows up to and including `rows`, oldest first."""
        back = rows[:, None] + np.arange(1 - history, 1)
        found: Singles = self.features[np.maximum(back, self.starts[rows, None])].astype(np.float32, copy=False)
        return found

    def chunks(self, rows: Indices, horizon: int) -> Singles:
        """(B, horizon, 5): the actions from `rows` on; the last one is repeated past the end."""
        ahead = self.first_targets[rows, None] + np.arange(horizon)
        found: Singles = self.targets[np.minimum(ahead, self.ends[rows, None] - 1)]
        return found if self.angles is None else turned(found, -self.angles[rows])

    def split(self, held_out: float, seed: int) -> tuple[Indices, Indices]:
        """Rows for training and for validation, split by person. `held_out` is the share of people.

        With a single person, all rows are for training.
        """
        out = np.isin(self.people, _drawn(len(self.names), held_out, seed))
        return np.flatnonzero(~out), np.flatnonzero(out)


def _drawn(people: int, share: float, seed: int) -> Indices:
    """Indices of the people to hold out; never all of them."""
    order = np.random.default_rng(seed).permutation(people)
    return order[: max(min(round(share * people), people - 1), 0)]


def held_out_episodes(people: Sequence[Collection[str]], share: float, seed: int) -> npt.NDArray[np.bool_]:
    """Which episodes (E,) are for validation, given the people in each: all episodes of a share of the people.

    None of these people is in a training episode. Where that leaves one side empty, every tenth episode is held out.
    """
    names = sorted({name for group in people for name in group})
    chosen = {names[number] for number in _drawn(len(names), share, seed)}
    out = np.array([not chosen.isdisjoint(group) for group in people], dtype=np.bool_)
    return out if 0 < out.sum() < len(out) else np.arange(len(people)) % 10 == 9


def split_rows(
    episodes: Indices, people: Sequence[Collection[str]], share: float, seed: int
) -> tuple[Indices, Indices]:
    """Training and validation rows, given the episode of each row (M,), split by `held_out_episodes`.

    Where all rows fall on one side (the other episodes were too short to have any), they are used for both.
    """
    out = held_out_episodes(people, share, seed)[episodes]
    if out.all() or not out.any():
        return np.arange(len(episodes)), np.arange(len(episodes))
    return np.flatnonzero(~out), np.flatnonzero(out)


class SeatSamples(NamedTuple):
    """One seat of an episode, or a stretch of it."""

    participant: str
    features: Singles | Bytes  # (T, D)
    targets: Singles  # (T or more, 5) of these ticks and later ones
    angles: Singles | None = None  # (T,) the own angles, where features are in the own frame


def windows_of(rows: Iterable[SeatSamples]) -> Windows:
    """Concatenate samples. Raises DataError when there are none."""
    pieces = list(rows)
    if not pieces:
        raise DataError(
            "there is nothing to train on: no recording has a seat to learn from; --seats all takes every seat"
        )
    names = tuple(sorted({piece.participant for piece in pieces}))
    lengths = np.array([len(piece.features) for piece in pieces])
    ends = np.cumsum(lengths)
    target_lengths = np.array([len(piece.targets) for piece in pieces])
    angles = [piece.angles for piece in pieces if piece.angles is not None]
    target_ends = np.cumsum(target_lengths)
    index = {name: number for number, name in enumerate(names)}
    return Windows(
        features=np.concatenate([piece.features for piece in pieces]),
        targets=np.concatenate([piece.targets for piece in pieces]),
        starts=np.repeat(ends - lengths, lengths),
        first_targets=np.arange(ends[-1]) + np.repeat(target_ends - target_lengths - (ends - lengths), lengths),
        ends=np.repeat(target_ends, lengths),
        people=np.repeat(np.array([index[piece.participant] for piece in pieces], dtype=np.int32), lengths),
        names=names,
        angles=np.concatenate(angles) if angles else None,
    )


def trajectory_samples(
    trajectories: Sequence[Trajectory], layout: str | FeatureSet, grasp: Grasp, seats: SeatChoice = "acting"
) -> Iterator[SeatSamples]:
    """The samples of the chosen seats of all trajectories."""
    seen = FeatureSet(layout) if isinstance(layout, str) else layout
    for trajectory in trajectories:
        for seat in learned_seats(trajectory, seats):
            yield SeatSamples(
                trajectory.whose(seat),
                trajectory.features(seat, seen),
                trajectory.targets(seat, grasp),
                trajectory.angles(seat, seen),
            )


def recording_files(places: Sequence[Path], suffixes: tuple[str, ...] = (".mcap",)) -> list[Path]:
    """The files with one of the suffixes among `places` and in folders there, sorted.

    Raises DataError when a place does not exist or nothing is found.
    """
    missing = [place for place in places if not place.exists()]
    if missing:
        raise DataError(f"there is no recording at {missing[0]}")
    candidates = [file for place in places for file in (place.rglob("*") if place.is_dir() else [place])]
    files = sorted({file for file in candidates if file.name.endswith(suffixes)})
    if not files:
        where = ", ".join(str(place) for place in places)
        raise DataError(f"no recording ({', '.join(suffixes)}) under {where}; `movingout demos generate` makes some")
    return files


def read_trajectories(files: Sequence[Path]) -> list[Trajectory]:
    """Read recordings, except tutorials, which show nobody's usual play, and those in which nothing was played.

    Raises RecordingError, naming the file, for one that cannot be read.
    """
    return [one for one in map(read_trajectory, files) if one is not None and one.ticks]


def read_trajectory(file: Path) -> Trajectory | None:
    """Read a recording; None for a tutorial. It has no tick where an agent failed at once. Raises RecordingError."""
    with with_folder(file):
        episode = read_episode(file)
    return None if episode.header.source == "tutorial" else trajectory_of(episode)


def data_hash(files: Sequence[Path]) -> str:
    """SHA-256 of the files' contents, independent of their names and order."""
    digests = sorted(hashlib.sha256(file.read_bytes()).hexdigest() for file in files)
    return hashlib.sha256("".join(digests).encode()).hexdigest()
