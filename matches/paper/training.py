"""Training the agents of the paper's tables, by `movingout train` in this process."""

import contextlib
import sys
from pathlib import Path
from typing import Any

from safetensors import SafetensorError

from movingout.agents.checkpoint.checkpoint import folder_name
from movingout.agents.commands import train
from movingout.agents.kinds.bass import OF_SIMULATOR
from movingout.agents.kinds.registry import KINDS
from movingout.maps.commands.parser import CommandParser
from movingout.matches.errors import MatchError
from movingout.matches.paper.budgets import Budget
from movingout.matches.paper.given_players import players_of
from movingout.matches.paper.imitation import seat_choice
from movingout.matches.paper.methods import METHODS, Method, TrainedId
from movingout.matches.paper.workspace import DATA, Workspace
from movingout.recordings.groups import read_groups
from movingout.recordings.storage.listing import read_players

LOGS = DATA / "logs"  # what each training prints
SEEDS_APART = 1000  # more than the trainings of an agent, so that no --seed below four million repeats those of another
LARGEST_SEED = 2**29 - 1  # of --seed: above it, training seeds would repeat, see `training_seed`
_TRAINING_SEEDS = 2**32  # that `movingout train` takes
IMITATING = ("mlp", "gru", "dp")  # kinds that learn what people do


def train_agent(agent: TrainedId, space: Workspace, shows_itself: bool = True) -> None:
    """Train an agent and write its checkpoint; what the training prints goes into a log, its bar to the terminal.

    Its bar goes into the log as well where several are trained at a time (`shows_itself` no).

    Raises MatchError where it has nothing to learn from or cannot be written, what `movingout train` raises, and
    KeyboardInterrupt at Ctrl-C.
    """
    try:
        _train(agent, space, shows_itself)
    except (OSError, SafetensorError) as error:
        raise MatchError(f"{agent.text} could not be trained in {Path.cwd()}: {error}") from error


def _train(agent: TrainedId, space: Workspace, shows_itself: bool) -> None:
    log = LOGS / f"{folder_name(agent.text)}.log"
    log.parent.mkdir(parents=True, exist_ok=True)
    parser = CommandParser(prog="movingout train")
    train.configure(parser)
    args = parser.parse_args([str(word) for word in training_words(agent, space)])
    with (
        log.open("a", encoding="utf-8", buffering=1) as file,
        contextlib.redirect_stdout(file),
        contextlib.nullcontext() if shows_itself and sys.stderr.isatty() else contextlib.redirect_stderr(file),
    ):
        code = train.run(args)
    if code:  # at Ctrl-C, which ends the whole command
        raise KeyboardInterrupt


def training_words(agent: TrainedId, space: Workspace) -> list[Any]:
    """The command, after `movingout train`. Raises MatchError where no episode is there to learn from."""
    method, budget = METHODS[agent.method], space.budget
    words: list[Any] = [
        method.kind, "--id", agent.text, "--name", f"{agent.method}, {agent.data}"[:60], "--data", DATA,
        "--preset", budget.preset, "--seed", _seed(agent, space), "--threads", _threads(space), "--go-on",
        *method.options, *_sizes(method, budget),
    ]  # fmt: skip
    if method.plays:
        return words + (["--split", space.split] if agent.data == "c2" else [])
    words += ["--population", _population(agent.data, space)]
    if method.base:
        words += ["--base", agent.of(method.base).text]
    if method.simulator:
        words += ["--simulator", agent.of(method.simulator).text]
    if method.simulator and not method.learns:
        return words
    files = _files(agent, space, method.maps)
    return [*words[:1], *files, *words[1:], *_seats(method, files, space)]


def _threads(space: Workspace) -> int:
    """One, so that numbers do not depend on the number of workers; beside a GPU all, to fill it."""
    return space.workers if space.budget.gpu else 1


def _seats(method: Method, files: list[Path], space: Workspace) -> list[str]:
    if not space.given or method.kind not in IMITATING:
        return []
    choice = seat_choice(([seat.kind for seat in read_players(file).seats] for file in files), space)
    return ["--seats", choice] if choice == "human" else []


def training_seed(training: int, space: Workspace) -> int:
    """Of a training: --seed 0 trains with 0, 1, …, --seed 1 with 1000, 1001, …"""
    return (SEEDS_APART * space.seed + training) % _TRAINING_SEEDS


def _seed(agent: TrainedId, space: Workspace) -> int:
    """What is trained from episodes differs in these; what learns from its own play needs another seed."""
    if METHODS[agent.method].plays:
        return training_seed(2 * agent.seed + (agent.data == "b"), space)
    return training_seed(agent.seed, space)


def _sizes(method: Method, budget: Budget) -> list[Any]:
    """The options of the budget: a quarter of the updates on single maps, a quarter of the batch with pictures."""
    words = list(budget.options.get(method.kind, ()))
    idle = () if "tcl" in method.options else ("--progress-updates",)  # only that score learns so
    for option in (*idle, *(f"--{name}" for name in OF_SIMULATOR if method.simulator)):
        if option in words:
            there = words.index(option)
            del words[there : there + 2]
    if method.pictures and "--batch" not in words:
        words += ["--batch", KINDS[method.kind].presets[budget.preset].batch]
    fewer = ["--updates", "--progress-updates"] if method.maps else []
    for option in [*fewer, *(["--batch"] if method.pictures else [])]:
        if option in words:
            there = words.index(option) + 1
            words[there] = max(words[there] // 4, 1)
    return words


def _files(agent: TrainedId, space: Workspace, maps: tuple[str, ...]) -> list[Path]:
    mine = set(space.episodes(agent.data))
    rows = [row for row in read_groups(space.listing(agent.data)) if row.path in mine]
    found = [row.path for row in rows if not maps or row.map in maps]
    if not found:
        raise MatchError(f"{agent.text} learns from {', '.join(maps)}, and no episode of it is there")
    return found


def _population(data: str, space: Workspace) -> str:
    who = f"{_given_people(data, space)} of the given recordings" if space.given else "scripted people of A and B"
    part = {"a": ", group 1", "b": ", group 2", "c2": ", Challenge 2"}.get(data, "")
    return who + part


def _given_people(data: str, space: Workspace) -> str:
    """Agents, and programs that took part in a rehearsal, are not to pass for people on a card."""
    mine = set(space.episodes(data))
    return players_of(row for row in read_groups(space.listing(data)) if row.path in mine)
