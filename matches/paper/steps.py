"""What tables need, as steps in order: recordings, trainings, matches, measurements. What is done is skipped."""

import contextlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

from movingout.maps.errors import MovingOutError
from movingout.matches.callbacks import OnProgress
from movingout.matches.grid_run import played_again
from movingout.matches.match import Match
from movingout.matches.paper.cells import Measurement
from movingout.matches.paper.costs import match_seconds, recording_seconds, training_seconds
from movingout.matches.paper.data_sets import list_episodes, listed_episodes, record_scripted
from movingout.matches.paper.entry import PaperEntry, measurements, played_cells
from movingout.matches.paper.match_store import MatchStore
from movingout.matches.paper.methods import METHODS, TrainedId, trained_before, trained_id
from movingout.matches.paper.rows.data_sizes import SizeCell
from movingout.matches.paper.training import train_agent
from movingout.matches.paper.workspace import Workspace
from movingout.matches.results.other_code import played_by_other_code


@dataclass(frozen=True, slots=True)
class PaperStep:
    """One step."""

    about: str
    seconds: float  # on the workers of the workspace, roughly
    is_done: Callable[[], bool]
    perform: Callable[[OnProgress], None]
    note: Callable[[], str] = str  # what else to say before it; mostly nothing
    matches: bool = False  # whether it plays: each result says how long its match took
    trains: TrainedId | None = None  # whom
    check: Callable[[], object] | None = None  # raises MovingOutError for what would stop it, and changes nothing


def paper_steps(entries: Sequence[PaperEntry], space: Workspace) -> list[PaperStep]:
    """Everything that entries need, done or not, in an order in which it can be done."""
    chosen = list(entries)
    agents = _agents(chosen, space)
    measured = measurements(chosen)
    challenges = {1 if agent.data != "c2" else 2 for agent in agents if not METHODS[agent.method].plays}
    data = {name for one in measured for name in one.data}
    data |= {name for entry in chosen if entry.drawing for name in entry.drawing.data}
    challenges |= {2 if name == "c2" else 1 for name in data}
    sizes = {cell.ours.challenge for entry in chosen for cell in entry.cells() if isinstance(cell.ours, SizeCell)}
    return [
        *(step for challenge in sorted(challenges) for step in _data_steps(challenge, space)),
        *(step for challenge in sorted(sizes - challenges) for step in _counting_steps(challenge, space)),
        *(_training_step(agent, space) for agent in agents),
        *_match_steps(list(dict.fromkeys(_matches(chosen, space))), space),
        *(_measuring_step(one, training, space) for one in measured for training in one.trainings(space.budget)),
    ]


def seconds_in_all(steps: Sequence[PaperStep], space: Workspace) -> float:
    """How long steps take, roughly: trainings run at a time, but no longer than one after another of the same chain."""
    others = sum(step.seconds for step in steps if step.trains is None)
    trainings = [step for step in steps if step.trains is not None]
    if not trainings:
        return others
    own = {step.trains: step.seconds for step in trainings}
    chains = [
        sum(own.get(needed, 0.0) for needed in {*trained_before(agent), agent}) for agent in own if agent is not None
    ]
    return others + max(sum(own.values()) / space.at_once, *chains)


def _agents(entries: list[PaperEntry], space: Workspace) -> list[TrainedId]:
    """The agents to train, each after those that it is made of."""
    ids = dict.fromkeys(agent for entry in entries for cell in entry.cells() for agent in cell.ours.agents)
    ids |= dict.fromkeys(agent for entry in entries if entry.drawing for agent in entry.drawing.agents)
    several = {agent for cell in played_cells(entries) for agent in cell.agents}
    several |= {agent for one in measurements(entries) if one.repeated for agent in one.agents}
    found: dict[TrainedId, None] = {}
    for agent_id in ids:
        for seed in range(space.budget.trainings if agent_id in several else 1):
            agent = trained_id(agent_id)._replace(seed=seed)
            found |= dict.fromkeys([*trained_before(agent), agent])
    return list(found)


def _matches(entries: list[PaperEntry], space: Workspace) -> Iterator[Match]:
    for cell in dict.fromkeys(played_cells(entries)):
        yield from cell.matches(space)


def _data_steps(challenge: int, space: Workspace) -> Iterator[PaperStep]:
    data = f"c{challenge}"
    listing = space.listing(data)
    if not space.given:
        people = "experts" if challenge == 2 else "people"
        yield PaperStep(
            f"record scripted {people} for Challenge {challenge}",
            recording_seconds(challenge, space.budget) / space.workers,
            listing.exists,
            lambda progress: record_scripted(challenge, space, progress),
        )
    yield PaperStep(
        f"list the episodes of Challenge {challenge}" + (" and divide their participants" if challenge == 1 else ""),
        5.0,
        listing.exists,
        lambda progress: list_episodes(challenge, space),
        check=partial(listed_episodes, challenge, space) if space.given else None,
    )


def _counting_steps(challenge: int, space: Workspace) -> Iterator[PaperStep]:
    """List given recordings of which only the sizes are told: those that nothing can be learned from stop nothing."""
    if space.given:
        for step in _data_steps(challenge, space):
            yield replace(
                step,
                about=f"list the episodes of Challenge {challenge} to count them",
                perform=lambda progress: _list_if_possible(challenge, space),
                note=lambda: _not_counted(challenge, space),
                check=None,
            )


def _list_if_possible(challenge: int, space: Workspace) -> None:
    with contextlib.suppress(MovingOutError):  # which the note has said
        list_episodes(challenge, space)


def _not_counted(challenge: int, space: Workspace) -> str:
    """Why the episodes of a challenge cannot be listed; empty where they can."""
    try:
        listed_episodes(challenge, space)
    except MovingOutError as error:
        return f"they are not counted: {error}"
    return ""


def _training_step(agent: TrainedId, space: Workspace) -> PaperStep:
    return PaperStep(
        f"train {agent.text} ({METHODS[agent.method].kind})",
        training_seconds(METHODS[agent.method], space.budget),
        partial(space.has_agent, agent.text),
        lambda progress: train_agent(agent, space),
        trains=agent,
    )


def _match_steps(matches: list[Match], space: Workspace) -> Iterator[PaperStep]:
    """All matches in one step: those of one pair alone would leave workers idle. It takes as long as those left."""
    if matches:
        left = space.matches.missing(matches)
        begun = f"{len(left):,} of " if 0 < len(left) < len(matches) else ""
        yield PaperStep(
            f"play {begun}{len(matches):,} match{'es' * (len(matches) != 1)}",
            sum(match_seconds(match, space.budget) for match in left) / space.workers,
            lambda: not space.matches.missing(matches),
            lambda progress: space.matches.play(matches, space.workers, progress),
            note=lambda: _before(matches, space.matches),
            matches=True,
        )


def _before(matches: list[Match], store: MatchStore) -> str:
    """What is to be said of those that were played before, a line each."""
    failed, other = store.failed_before(matches), store.of_other_code(matches)
    said = [played_again(failed) if failed else "", played_by_other_code(other) if other else ""]
    return "\n".join(filter(None, said))


def _measuring_step(one: Measurement, training: int, space: Workspace) -> PaperStep:
    return PaperStep(
        f"measure {one.about_of(training)}",
        one.seconds(space.budget),
        lambda: one.measured(training, space) is not None,
        lambda progress: one.measure(training, space),
    )
