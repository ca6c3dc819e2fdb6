"""How good and how fast learned agents are: plays them with partners and prints the paper's metrics.

    python -m bench.learning --agents dp@all bass@all:score=nfd,sampling=4x4 idle --partners C --episodes 2

`idle` among the agents is the control condition: what the partner reaches alone. Errors are standard errors over
episodes. With `--log FILE` every finished episode is kept, and the same command goes on where it was stopped.
"""

import argparse
import json
import os
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from bench.results.episode_log import EpisodeLog, Outcome, Run
from movingout.agents.catalogue import load_agent
from movingout.agents.scripted.populations import POPULATIONS, population
from movingout.maps import load_map, map_names
from movingout.maps.errors import MovingOutError
from movingout.matches import MatchError, MatchResult, play_matches
from movingout.world.constants import LIMIT_TICKS
from movingout.world.estimates import estimate, estimate_text

PARTNER_STRIDE = 7  # from map to map, so that different people come first


def runs(agents: list[str], partners: list[str], maps: list[str], episodes: int, ticks: int) -> list[Run]:
    """The same partners, seats and seeds for every agent, episode by episode: fewer episodes are the first of more.

    Seats change every second episode, because every second person of C plays the other way round.
    """
    made = []
    for number in range(episodes):
        for index, name in enumerate(maps):
            partner, seat = partners[(PARTNER_STRIDE * index + number) % len(partners)], (number // 2 + index) % 2
            made += [Run(agent, partner, name, seat, number, ticks) for agent in agents]
    return made


def play_all(todo: list[Run], workers: int, log: Path | None = None) -> list[Outcome]:
    """Play all episodes in worker processes, with a progress bar; what `log` knows already is not played again.

    Every agent plays its first episodes before any plays its second, the maps together, so that it is asked in batches
    (`matches.execution.lockstep`). Raises MatchError when an agent lost a match: counted as nothing, it would say
    little of it.
    """
    kept = EpisodeLog(log) if log is not None else None
    done = kept.known(todo) if kept is not None else {}
    rest = {run.match: run for run in sorted(todo, key=lambda run: (run.seed, run.agent)) if run not in done}
    failed = []

    def on_result(result: MatchResult) -> None:
        run = rest[result.match]
        metrics = result.metrics
        if result.failure or metrics.wt_s is None:
            failed.append(f"{run.agent} with {run.partner} on {run.map}, seed {run.seed}: {result.failure}")
            return
        done[run] = Outcome(run, metrics.tcr, metrics.nfd, metrics.wt_s, metrics.ac, result.cpu_s)
        if kept is not None:
            kept.append(done[run])
        progress.update(bar, completed=len(done))

    with Progress(console=Console(stderr=True)) as progress:
        bar = progress.add_task("episodes", total=len(todo), completed=len(done))
        play_matches(list(rest), workers=workers, on_result=on_result)
    if failed:
        raise MatchError(f"{len(failed)} of {len(rest)} matches were lost: {failed[0]}")
    return [done[run] for run in todo]


def table(outcomes: list[Outcome], agents: list[str], maps: list[str]) -> str:
    """Rows of agents that played: TCR and NFD over all maps, then TCR by map."""
    lines = ["| agent | TCR | NFD | WT [s] | AC | n | " + " | ".join(maps) + " |", "|---" * (6 + len(maps)) + "|"]
    for agent in agents:
        mine = [one for one in outcomes if one.run.agent == agent]
        if not mine:
            continue
        tcr, nfd, waiting = (estimate([getattr(one, name) for one in mine]) for name in ("tcr", "nfd", "wt_s"))
        consistency = estimate([one.ac for one in mine if one.ac is not None])
        cells = [estimate_text(found) for found in (tcr, nfd, waiting, consistency)]
        by_map = [_mean_text([one.tcr for one in mine if one.run.map == name]) for name in maps]
        lines.append(f"| {agent} | " + " | ".join([*cells, str(len(mine)), *by_map]) + " |")
    return "\n".join(lines)


def _mean_text(values: list[float]) -> str:
    found = estimate(values)
    return "–" if found is None else f"{found.mean:.2f}"


def main(words: Sequence[str] | None = None) -> None:
    """Parse, play, print; what cannot be played is said in a sentence."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    agents = ["dp@all", "bass@all", "scripted", "idle"]
    parser.add_argument("--agents", nargs="+", default=agents, metavar="ID", help="agent ids")
    parser.add_argument("--partners", default="C", help="a population (A, B, C) or an agent id")
    parser.add_argument("--maps", default="all", help="a map's name, several joined by commas, or all")
    parser.add_argument("--episodes", type=int, default=2, help="per map")
    parser.add_argument("--ticks", type=int, default=LIMIT_TICKS)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--log", type=Path, help="file of finished episodes, to go on from")
    parser.add_argument("--json", action="store_true")
    args = parser.parse_args(words)
    if min(args.episodes, args.ticks, args.workers) < 1:
        parser.error("--episodes, --ticks and --workers are 1 or more")
    try:
        maps, partners = _maps(args.maps), _partners(args.partners)
        for agent_id in {*args.agents, *partners}:
            load_agent(agent_id)  # before hours of play, not amid them
        outcomes = play_all(runs(args.agents, partners, maps, args.episodes, args.ticks), args.workers, args.log)
    except MovingOutError as error:
        parser.error(str(error))
    if args.json:
        episodes = args.episodes * len(maps)
        print(json.dumps({"partners": args.partners, "episodes": episodes, "scores": _scores(outcomes, args.agents)}))
    else:
        print(table(outcomes, args.agents, maps))


def _maps(said: str) -> list[str]:
    """Names of maps. Raises MapError for an unknown one."""
    names = list(map_names()) if said == "all" else said.split(",")
    for name in names:
        load_map(name)
    return names


def _partners(said: str) -> list[str]:
    """Agent ids: the people of a population, or the one that was said."""
    return [person.agent_id for person in population(said)] if said in POPULATIONS else [said]


def _scores(outcomes: Sequence[Outcome], agents: Sequence[str]) -> dict[str, dict[str, tuple[float, float] | None]]:
    """Mean and standard error (0 of one episode) of each metric, by agent; None of none."""
    return {
        agent: {
            name: _mean_and_error([getattr(one, name) for one in outcomes if one.run.agent == agent])
            for name in ("tcr", "nfd", "wt_s")
        }
        for agent in agents
    }


def _mean_and_error(values: list[float]) -> tuple[float, float] | None:
    found = estimate(values)
    return None if found is None else (found.mean, found.stderr or 0.0)


if __name__ == "__main__":
    main()
