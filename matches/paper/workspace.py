"""The folder in which tables are made: what was recorded, trained, played and measured for them.

paper.json           what the folder was begun with (`beginning`)
paper.lock           held by the command that is at work
data/c1.csv, c2.csv  the episodes of each challenge, with the group of participants that each belongs to
data/demos/          recordings of scripted people, where none were given
data/models, runs    trained agents, where every command looks for them
data/matches/        played matches
data/measured/       measurements
data/times.json      processor time of each step, in seconds

All paths are relative to the current folder, because trained agents are looked up in `data/models` there.
"""

import contextlib
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from movingout.agents.checkpoint.checkpoint import CARD, MODELS_VARIABLE, fingerprint, folder_name
from movingout.maps.randomize import Split
from movingout.matches.match import Match, MatchResult
from movingout.matches.paper.budgets import Budget
from movingout.matches.paper.match_store import MatchStore
from movingout.matches.results.results_folder import EXACT, write_whole
from movingout.recordings.errors import RecordingError
from movingout.recordings.groups import read_groups
from movingout.recordings.storage.finished import SUFFIX
from movingout.recordings.versions import versions
from movingout.world.estimates import Estimate

Evaluation = Literal["official", "held-out"]
"""How Challenge 2 is evaluated: on the maps as designed, after training on variants that never have an item as designed
there (the paper), or on variants whose combinations of size and shape occur in no training map."""

Grouping = Literal["random", "style"]
"""What makes the groups a and b of Challenge 1: people drawn at random (the paper), or two styles of play."""

DATA = Path("data")
TIMES = DATA / "times.json"
GROUPS = {"a": 1, "b": 2}
Measured = Mapping[str, Estimate]
_NUMBERS = "numbers"  # key of the file of a measurement


@contextlib.contextmanager
def inside(folder: Path) -> Iterator[None]:
    """Work in a folder of tables, with its own agents: MOVINGOUT_MODELS would put those of another folder before them.

    The variable is gone for the processes that are started here, too. Raises OSError where there is no such folder.
    """
    named = os.environ.pop(MODELS_VARIABLE, None)
    try:
        with contextlib.chdir(folder):
            yield
    finally:
        if named is not None:
            os.environ[MODELS_VARIABLE] = named


@dataclass(frozen=True, kw_only=True)
class Workspace:
    """The folder, and what it was begun with."""

    budget: Budget
    evaluation: Evaluation = "official"
    given: tuple[Path, ...] = ()  # recordings of people, absolute; empty: scripted people record
    min_tcr: float = 0.0  # given episodes below it are left out
    grouping: Grouping = "random"
    styles: tuple[tuple[str, str], ...] = ()  # of given people, by participant; empty: those of scripted people
    seed: int = 0  # of the division into groups, and of scripted people
    workers: int = 1  # processes that record, train or play at a time
    matches: MatchStore = field(default_factory=lambda: MatchStore(DATA / "matches"), compare=False)

    @property
    def split(self) -> Split:
        """Of the variants that are learned from in Challenge 2."""
        return "official" if self.evaluation == "official" else "train"

    @property
    def at_once(self) -> int:
        """Trainings that run at a time: one for each worker; one alone where a GPU is to be filled."""
        return 1 if self.budget.gpu else self.workers

    def given_files(self) -> list[Path]:
        """The recordings that were given. Raises RecordingError where there is none, or one is not there."""
        files = [file for path in self.given for file in (path.rglob(f"*{SUFFIX}") if path.is_dir() else [path])]
        if not files:
            raise RecordingError(f"no recording (*{SUFFIX}) in {', '.join(map(str, self.given))}")
        if lost := [file for file in files if not file.exists()]:
            raise RecordingError(
                f"cannot read {lost[0]}: there is no such file; correct --data, or remove a broken link"
            )
        return sorted(set(files))

    def episodes(self, data: str) -> list[Path]:
        """The recordings of one of `methods.DATA_SETS`, once they have been listed."""
        rows = read_groups(self.listing(data))
        return [row.path for row in rows if GROUPS.get(data) in (None, row.group)]

    def listing(self, data: str) -> Path:
        """The file that lists the episodes of a challenge or of a group."""
        return DATA / ("c2.csv" if data == "c2" else "c1.csv")

    def has_agent(self, agent_id: str) -> bool:
        """Whether it has been trained."""
        return (DATA / "models" / folder_name(agent_id) / CARD).exists()

    def result(self, match: Match) -> MatchResult | None:
        """The result of a match, if it has been played with the present weights."""
        return self.matches.find(match)

    def measured(
        self, name: str, agents: Sequence[str] = (), episodes: int = 0, samples: int | None = None
    ) -> Measured | None:
        """What was measured of agents under a name; None when it was not, under other conditions, in fewer episodes,
        or with another number of samples, or its file is damaged, as after a power failure.

        Earlier versions wrote the numbers alone, or with the weights; these stay.
        """
        path = self._measured(name)
        if not path.exists():
            return None
        try:
            found = json.loads(path.read_text(encoding="utf-8"))
            if _NUMBERS in found:
                if found.get("episodes", episodes) < episodes:
                    return None
                if any(found.get(key, now) != now for key, now in self._conditions(agents, samples).items()):
                    return None
                found = found[_NUMBERS]
            return {key: Estimate(*numbers) for key, numbers in found.items()}
        except (ValueError, TypeError, AttributeError):
            return None

    def keep(
        self, name: str, numbers: Measured, agents: Sequence[str] = (), episodes: int = 0, samples: int | None = None
    ) -> None:
        """Keep what was measured of agents; `episodes`, `samples`: in so many, where the budget says how many."""
        document = {**self._conditions(agents, samples), "episodes": episodes, _NUMBERS: numbers}
        write_whole(self._measured(name), json.dumps(document, indent=1) + "\n")

    def _conditions(self, agents: Sequence[str], samples: int | None) -> dict[str, object]:
        """What numbers depend on besides their name."""
        return {
            "weights": {agent_id: fingerprint(agent_id) for agent_id in agents},
            "versions": {name: versions()[name] for name in EXACT},
            **({} if samples is None else {"samples": samples}),
        }

    def times(self) -> dict[str, float]:
        """Processor time [s] of the steps done so far, by what they are about."""
        try:
            return {str(about): float(spent) for about, spent in json.loads(TIMES.read_text(encoding="utf-8")).items()}
        except (OSError, ValueError, AttributeError):
            return {}  # a note, not a result: without it a page only lacks times

    def note_time(self, about: str, seconds: float) -> None:
        """Add to the processor time of a step; one that was stopped and continued counts whole.

        Of trainings at a time, only what was not stopped counts.
        """
        times = self.times()
        write_whole(TIMES, json.dumps({**times, about: round(times.get(about, 0.0) + seconds, 1)}, indent=1) + "\n")

    def _measured(self, name: str) -> Path:
        return DATA / "measured" / f"{name}.json"
