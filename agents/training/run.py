"""One training run: its options, its folders, and what the card says about the origin of the weights.

Every kind's `train` is given one; nothing in it depends on the kind.
"""

import argparse
import datetime
import hashlib
import json
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Generic, NamedTuple, Protocol, TypeVar

from movingout.agents.base import Agent
from movingout.agents.checkpoint.card import Card, Training
from movingout.agents.checkpoint.checkpoint import (
    CARD,
    Checkpoint,
    find_checkpoint,
    folder_name,
    model_roots,
    read_checkpoint,
)
from movingout.agents.errors import CheckpointError, DataError
from movingout.agents.training import run_folder
from movingout.agents.training.learned_data import (
    LEARNED,
    NOTHING,
    OTHERS_BEFORE,
    UNKNOWN,
    LearnedData,
    on_maps,
    said_before,
    said_by_card,
)
from movingout.agents.training.optimisation import Change, Optimisation
from movingout.agents.training.run_folder import NO_CHANGES
from movingout.agents.training.training_data import TrainingData, read_training_data
from movingout.maps import MapSpec
from movingout.maps.generated.names import test_maps_caution
from movingout.maps.json_format import map_to_json
from movingout.maps.randomize import Pair, pair_text, pairs_on
from movingout.maps.suggestion import counted

ConfigT = TypeVar("ConfigT", bound=Optimisation)


PEOPLE = "people_sha256"  # key in the run's configuration of who counts as whom, which earlier versions did not write
Begun = Mapping[str, object]
"""The configuration of a run as it was before."""


class FitProgress(Protocol):
    """How far something has been trained (`training.fit.FitResult`, `RoundsMade`)."""

    @property
    def updates(self) -> int: ...

    @property
    def made(self) -> int: ...


def maps_sha256(specs: Sequence[MapSpec]) -> str:
    """Of the maps that are played, in place of data that is learned from."""
    return hashlib.sha256(json.dumps([map_to_json(one) for one in specs]).encode()).hexdigest()


class RoundsMade(NamedTuple):
    """Of what learns by playing, in rounds: in total, and in this run."""

    updates: int
    made: int


@dataclass(frozen=True, slots=True)
class TrainingRun(Generic[ConfigT]):
    """A call of `movingout train KIND …`."""

    kind: str
    config: ConfigT  # the preset with what the command line changes
    options: argparse.Namespace  # of all kinds: id, name, population, preset, recordings, go_on, data; and of this one
    kept_options: tuple[str, ...]  # which of its own options the run folder keeps
    tell: Callable[[str], None]  # prints a note for the user
    load_agent: Callable[[str], Agent]  # the agent of an id, for kinds that are trained by playing
    check_own_maps_seen: Callable[[Iterable[tuple[str, MapSpec]]], None]  # of those kinds, `agents.map_limits`
    until_its_end: ExitStack = field(default_factory=ExitStack)  # keeps other processes out of the run folder

    @property
    def agent_id(self) -> str:
        """Of the new agent."""
        return str(self.options.id)

    @property
    def name(self) -> str:
        """The name shown in the lobby."""
        return self.options.name or f"{self.kind.upper()} {self.agent_id.rpartition('@')[2]}"

    @property
    def folder(self) -> Path:
        """Where curves and resume files go."""
        folder: Path = self.options.data / "runs" / folder_name(self.agent_id)
        return folder

    @property
    def model_folder(self) -> Path:
        """Where the checkpoint goes."""
        folder: Path = self.options.data / "models" / folder_name(self.agent_id)
        return folder

    def find(self, agent_id: str) -> Checkpoint:
        """Another agent: of the data folder, of where others look for agents, or shipped. Raises CheckpointError."""
        return find_checkpoint(agent_id, self.options.data / "models", *model_roots())

    def read_data(self) -> TrainingData:
        """The recordings and corrections that were named, but for episodes with those to be left out.

        Says so when test maps or people for tests are among them. Raises DataError, RecordingError, or AgentError for
        an unknown family.
        """
        data = read_training_data(self.options.recordings, self.options.without)
        if data.uncounted:
            what = counted(data.uncounted, "recording")
            self.tell(f"movingout: {what} left out: invalid, broken off, or of people who declined, says the study")
        if data.copies:
            what = f"{len(data.copies)} {'copy' if len(data.copies) == 1 else 'copies'}"
            self.tell(f"movingout: {what} left out, of recordings that are there, too")
        if data.empty:
            what = f"{counted(len(data.empty), 'file')} left out"
            self.tell(f"movingout: {what}, in which nothing was played: {data.empty[0]}")
        if data.learns_from_tests:
            self.tell(
                "movingout: people of C play in these episodes, who are for tests: who learns from them is measured "
                "too well; --without people:C leaves them out"
            )
        self.caution({trajectory.map.name for trajectory in data.episodes})
        return data

    def caution(self, maps: Collection[str]) -> None:
        """Tell the user when test maps are among those that are trained on."""
        if sentence := test_maps_caution(maps):
            self.tell(f"movingout: {sentence}")

    def begin(
        self, data_sha256: str = "", changes: Mapping[str, Change] = NO_CHANGES, learned: LearnedData = NOTHING,
        known_as: str = "", people_sha256: str = "",
    ) -> Begun:  # fmt: skip
        """Write the run's configuration, see `run_folder.begin`; without a SHA-256 when nothing is trained.

        `learned` is what it is about to learn from, `known_as` another SHA-256 of the same data, and `people_sha256`
        that of who counts as whom in them. Returns the configuration it had before, empty when nothing was learned with
        one. Raises DataError also while another process trains there.
        """
        names = ("id", "kind", "preset", *self.kept_options)
        about = {name: str(value) for name, value in vars(self.options).items() if name in names}
        if data_sha256:
            about["data_sha256"] = data_sha256
        self.until_its_end.enter_context(run_folder.held(self.folder))
        if known_as:
            run_folder.rename_data(self.folder, known_as, data_sha256)
        more: dict[str, object] = {PEOPLE: people_sha256} if people_sha256 else {}
        if data_sha256:
            in_all = self._learned_before(data_sha256).plus(learned)
            more[LEARNED] = in_all.model_dump(mode="json")
        return run_folder.begin(self.folder, about, self.config, self.options.go_on, changes, more)

    def begin_on(self, data: TrainingData, changes: Mapping[str, Change] = NO_CHANGES) -> Begun:
        """The same, for what learns from recordings. Raises DataError also as `_check_held_out` does."""
        known_as = data.sha256_with_copies if data.copies else ""
        self._check_held_out(data, known_as)
        return self.begin(
            data.sha256,
            changes,
            learned=on_maps(one.map for one in data.episodes),
            known_as=known_as,
            people_sha256=data.people_sha256,
        )

    def _check_held_out(self, data: TrainingData, known_as: str) -> None:
        """Raises DataError where these weights learned from episodes of people who are held out now; says it if asked.

        Asked is by --go-on, with which `movingout paper` always trains.
        """
        begun = run_folder.begun(self.folder) if run_folder.has_learned(self.folder) else {}
        if not self.config.held_out or begun.get("data_sha256") not in (data.sha256, known_as):
            return
        seats = self.options.seats if "seats" in self.kept_options else None
        is_other = begun[PEOPLE] != data.people_sha256 if PEOPLE in begun else data.counts_otherwise(seats)
        if not is_other:
            return
        why = (
            f"{self.agent_id} was begun when an agent beside a person counted as one more participant, people without "
            "a name as one, or a replay as a person: it has learned from people who"
        )
        if not self.options.go_on:
            raise DataError(
                f"{why} would be held out for validation now; choose another --id, or continue with --go-on"
            )
        self.tell(f"movingout: {why} are held out for validation now")

    def _learned_before(self, data_sha256: str) -> LearnedData:
        """From what these weights learned until now; of old folders, that is no more than their card says."""
        if not run_folder.has_learned(self.folder):
            return NOTHING
        begun = run_folder.begun(self.folder)
        if LEARNED in begun:
            before = said_before(begun)
        elif (self.folder / CARD).exists():
            card = self._earlier_card()
            before = said_by_card(card, begun, data_sha256) if card else UNKNOWN
        else:  # it never ended
            before = NOTHING if begun.get("data_sha256") == data_sha256 else UNKNOWN
        is_other = begun.get("data_sha256") not in (None, "", data_sha256)
        return before.plus(LearnedData(others_before=is_other))

    def _earlier_card(self) -> Card | None:
        """As of when this run last ended; None where it cannot be read."""
        for folder in (self.folder, self.model_folder):
            with suppress(CheckpointError):
                return read_checkpoint(folder).card
        return None

    @property
    def _learned(self) -> LearnedData:
        """From what these weights learned, with what they learn from now."""
        begun = run_folder.begun(self.folder)
        return said_before(begun) if LEARNED in begun else NOTHING

    def check_learned(self, before: Begun, fitted: FitProgress, option: str, is_first: bool = True) -> None:
        """Raises DataError when no updates were left for new data, so that no card names data never learned from.

        `before` is what `begin` returned; `option` sets the number of updates. With `is_first` no, another part has
        learned from the new data.
        """
        if not fitted.made and run_folder.learns_from_other(self.folder, before):
            if is_first:
                run_folder.put_back(self.folder, before)
            raise DataError(
                f"{self.agent_id} has made all of its {fitted.updates} updates; to train on, give a larger {option}"
            )

    def others_before(self) -> str:
        """For the description: empty, or that these weights learned from other data or maps before."""
        return OTHERS_BEFORE if self._learned.others_before else ""

    def maps(self, names: Collection[str], start: Card | None = None) -> set[str]:
        """All maps that these weights learned on, whenever: those of now, of earlier, and of the agent at the start."""
        return {*names, *self._learned.maps, *(start.maps if start else ())}

    def items(self, pairs: Collection[Pair], start: Card | None = None) -> tuple[str, ...] | None:
        """Sizes and shapes that they learned from, whenever; None where that is not known."""
        earlier = self._learned.items
        at_start = start.learned_items if start else frozenset()
        if earlier is None or at_start is None:
            return None
        return tuple(sorted({pair_text(pair) for pair in pairs}.union(earlier, at_start)))

    def training(
        self, data: TrainingData, people: Collection[str], rows: int, updates: int, start: Card | None = None
    ) -> Training:
        """Where weights come from, for the card; `start` is the agent whose weights they were at first."""
        return Training(
            preset=self.options.preset,
            data_sha256=data.sha256,
            population=self.options.population or data.population(people),
            episodes=len(data.files),
            windows=rows,
            updates=updates,
            seed=self.config.seed,
            created=datetime.datetime.now(datetime.UTC).date().isoformat(),
            items=self.items({pair for one in data.episodes for pair in pairs_on(one.map)}, start),
        )
