"""The folder in which tables are made: what was recorded, trained, played and measured for them.

paper.json           what the folder was begun with; another budget or other recordings need another folder
data/c1.csv, c2.csv  the episodes of each challenge, with the group of participants that each belongs to
data/demos/          recordings of scripted people, where none were given
data/models, runs    trained agents, where every command looks for them
data/matches/        played matches
data/measured/       measurements
data/times.json      processor time of each step, in seconds

All paths are relative to the current folder, because trained agents are looked up in `data/models` there.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from movingout.agents.checkpoint.checkpoint import CARD, folder_name
from movingout.matches.errors import MatchError
from movingout.matches.match import Match, MatchResult
from movingout.matches.paper.budgets import Budget, budget_of
from movingout.matches.paper.match_store import MatchStore
from movingout.matches.results.results_folder import write_whole
from movingout.recordings.groups import read_groups
from movingout.world.estimates import Estimate

Evaluation = Literal["official", "held-out"]
"""How Challenge 2 is evaluated: on the maps as designed, after training on variants that never have an item as designed
there (the paper), or on variants whose combinations of size and shape occur in no training map."""

DATA = Path("data")
BEGUN = Path("paper.json")
TIMES = DATA / "times.json"
GROUPS = {"a": 1, "b": 2}
Measured = Mapping[str, Estimate]


@dataclass(frozen=True, kw_only=True)
class Workspace:
    """The folder, and what it was begun with."""

    budget: Budget
    evaluation: Evaluation = "official"
    given: tuple[Path, ...] = ()  # recordings of people, absolute; empty: scripted people record
    min_tcr: float = 0.0  # given episodes below it are left out
    seed: int = 0  # of the division into groups, and of scripted people
    workers: int = 1
    matches: MatchStore = field(default_factory=lambda: MatchStore(DATA / "matches"), compare=False)

    def begin(self) -> None:
        """Note what the folder is begun with. Raises MatchError where something else was made in it.

        A folder in which nothing was made yet, because its recordings were refused, is begun anew.
        """
        mine = {
            "budget": self.budget.name, "evaluation": self.evaluation, "data": [str(path) for path in self.given],
            "min_tcr": self.min_tcr, "seed": self.seed,
        }  # fmt: skip
        if not BEGUN.exists() or not _anything_made():
            write_whole(BEGUN, json.dumps(mine, indent=1) + "\n")
            return
        theirs = _begun_with()
        other = [name for name in mine if theirs.get(name) != mine[name]]
        if other:
            said = ", ".join(f"{name} {theirs.get(name)}" for name in other)
            raise MatchError(f"{Path.cwd()} was begun with {said}; choose another folder with --out")

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

    def measured(self, name: str) -> Measured | None:
        """What was measured under a name; None when it was not."""
        path = self._measured(name)
        if not path.exists():
            return None
        return {key: Estimate(*numbers) for key, numbers in json.loads(path.read_text(encoding="utf-8")).items()}

    def keep(self, name: str, numbers: Measured) -> None:
        """Keep a measurement."""
        write_whole(self._measured(name), json.dumps(numbers, indent=1) + "\n")

    def times(self) -> dict[str, float]:
        """Processor time [s] of the steps done so far, by what they are about."""
        try:
            return {str(about): float(spent) for about, spent in json.loads(TIMES.read_text(encoding="utf-8")).items()}
        except (OSError, ValueError, AttributeError):
            return {}  # a note, not a result: without it a page only lacks times

    def note_time(self, about: str, seconds: float) -> None:
        """Add to the processor time of a step; one that was stopped and continued counts whole."""
        times = self.times()
        write_whole(TIMES, json.dumps({**times, about: round(times.get(about, 0.0) + seconds, 1)}, indent=1) + "\n")

    def _measured(self, name: str) -> Path:
        return DATA / "measured" / f"{name}.json"


def begun() -> Workspace:
    """The workspace in the current folder. Raises MatchError where nothing has been made."""
    if not BEGUN.exists():
        raise MatchError(f"no table has been made in {Path.cwd()} yet: `movingout paper tables LABEL -o DIR` makes one")
    said = _begun_with()
    try:
        return Workspace(
            budget=budget_of(said["budget"]), evaluation=said["evaluation"], min_tcr=said["min_tcr"],
            given=tuple(Path(path) for path in said["data"]), seed=said["seed"],
        )  # fmt: skip
    except (KeyError, TypeError) as error:
        raise MatchError(f"{BEGUN.resolve()} is damaged ({error}); choose another folder with --out") from error


def _anything_made() -> bool:
    """Whether the folder has more than notes of how long steps took."""
    folders = DATA, Path("tables"), Path("figures")
    return any(path.is_file() and path != TIMES for folder in folders for path in folder.rglob("*"))


def _begun_with() -> dict[str, Any]:
    try:
        return dict(json.loads(BEGUN.read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError) as error:
        raise MatchError(f"{BEGUN.resolve()} is damaged ({error}); choose another folder with --out") from error
