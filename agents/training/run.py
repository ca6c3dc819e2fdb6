"""One training run: what it was asked for, its folders, and what its card says about where the weights come from.

A kind's `train` is given one. It may be asked only for what does not depend on the kind.
"""

import argparse
import datetime
from collections.abc import Callable, Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, Protocol, TypeVar

from movingout.agents.checkpoint.checkpoint import SHIPPED, Checkpoint, Training, find_checkpoint, folder_name
from movingout.agents.errors import DataError
from movingout.agents.training import run_folder
from movingout.agents.training.optimisation import Optimisation
from movingout.agents.training.training_data import TrainingData, read_training_data

ConfigT = TypeVar("ConfigT", bound=Optimisation)


class FitProgress(Protocol):
    """How far a network has been trained (`training.fit.FitResult`)."""

    @property
    def updates(self) -> int: ...

    @property
    def made(self) -> int: ...


@dataclass(frozen=True, slots=True)
class TrainingRun(Generic[ConfigT]):
    """What `movingout train KIND …` was told."""

    kind: str
    config: ConfigT  # the preset with what the command line changes
    options: argparse.Namespace  # of all kinds: id, name, population, preset, recordings, go_on, data; and of this one
    kept_options: tuple[str, ...]  # which of its own options the run folder keeps
    tell: Callable[[str], None]  # says something to whoever waits

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
        """Another agent of the data folder, or a shipped one. Raises CheckpointError."""
        return find_checkpoint(agent_id, self.options.data / "models", SHIPPED)

    def read_data(self) -> TrainingData:
        """The recordings and corrections that were named. Raises DataError or RecordingError."""
        return read_training_data(self.options.recordings)

    def begin(self, data: TrainingData | None = None) -> str:
        """Write what the run is of, see `run_folder.begin`; without data nothing is trained.

        Returns the SHA-256 of the data it had before, empty when it had none.
        """
        names = ("id", "kind", "preset", *self.kept_options)
        about = {name: str(value) for name, value in vars(self.options).items() if name in names}
        if data is not None:
            about["data_sha256"] = data.sha256
        return run_folder.begin(self.folder, about, self.config, self.options.go_on)

    def check_learned(self, data: TrainingData, before: str, fitted: FitProgress, option: str) -> None:
        """Raises DataError when there was nothing left to do, so that a card would name data never learned from.

        `before` is what `begin` returned, `option` the one that would let it learn on.
        """
        if not fitted.made and before not in ("", data.sha256):
            run_folder.put_back(self.folder, before)
            raise DataError(
                f"{self.agent_id} has made all of its {fitted.updates} updates; learn on with a larger {option}"
            )

    def training(self, data: TrainingData, people: Collection[str], rows: int, updates: int) -> Training:
        """Where weights come from, for the card."""
        return Training(
            preset=self.options.preset,
            data_sha256=data.sha256,
            population=self.options.population or f"{len(people)} participants",
            episodes=len(data.files),
            windows=rows,
            updates=updates,
            seed=self.config.seed,
            created=datetime.datetime.now(datetime.UTC).date().isoformat(),
        )
