"""The paper's metrics for learned agents, played with given partners.

    python -m bench.learning --agents dp@all bass@all:score=nfd,sampling=4x4 idle --partners C --episodes 2

The agent `idle` is the control: what the partner reaches alone. Errors are standard errors over episodes. With
`--log FILE` finished episodes are kept, and the same command resumes where it stopped.
"""

import argparse
import json
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from bench.results.episode_log import EpisodeLog, Outcome, Run
from movingout.agents.catalogue import load_agent
from movingout.agents.partners.families import group
from movingout.agents.scripted.populations import POPULATIONS
from movingout.maps import load_map
from movingout.maps.errors import MovingOutError
from movingout.maps.selection import HELP as MAPS_HELP
from movingout.maps.selection import selected_maps
from movingout.matches import MatchError, MatchResult, play_matches
from movingout.matches.callbacks import WorkerPoolFactory
from movingout.matches.commands.worker_options import add_workers, worker_pool_of, workers_of
from movingout.matches.execution.local_workers import LocalWorkerPool
from movingout.world.constants import LIMIT_TICKS
from movingout.world.estimates import estimate, estimate_text

PARTNER_STRIDE = 7  # between maps, so that each starts with other people


def runs(agents: list[str], partners: list[str], maps: list[str], episodes: int, ticks: int) -> list[Run]:
    """Runs with the same partners, seats and seeds for every agent; fewer episodes are a prefix of more.

    Seats change every second episode, because leaders and followers alternate in C.
    """
    made = []
    for number in range(episodes):
        for index, name in enumerate(maps):
            partner, seat = partners[(PARTNER_STRIDE * index + number) % len(partners)], (number // 2 + index) % 2
            made += [Run(agent, partner, name, seat, number, ticks) for agent in agents]
    return made


def play_all(
    todo: list[Run], workers: int, log: Path | None = None, pool: WorkerPoolFactory = LocalWorkerPool
) -> list[Outcome]:
    """Play all episodes with a pool of workers and a progress bar; those in `log` are not played again.

    Episodes are ordered by seed, then by agent, so that an agent decides for many maps in one batch
    (`matches.execution.lockstep`). Raises MatchError if any match failed, because a failure has no score.
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
        done[run] = Outcome(
            run, metrics.tcr, metrics.nfd, metrics.wt_s, metrics.ac, result.cpu_s, metrics.interdependence
        )
        if kept is not None:
            kept.append(done[run])
        progress.update(bar, completed=len(done))

    with Progress(console=Console(stderr=True)) as progress:
        bar = progress.add_task("episodes", total=len(todo), completed=len(done))
        play_matches(list(rest), workers=workers, on_result=on_result, pool=pool)
    if failed:
        raise MatchError(f"{len(failed)} of {len(rest)} matches failed: {failed[0]}")
    return [done[run] for run in todo]


def table(outcomes: list[Outcome], agents: list[str], maps: list[str]) -> str:
    """A Markdown table with a row per agent that played: metrics over all maps, then TCR by map."""
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
    """Parse, play and print; exit with a message if that is impossible."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_options(parser, ["dp@all", "bass@all", "scripted", "idle"])
    parser.add_argument("--partners", default="C", help="C, family:greedy, @FILE, … or an agent id")
    parser.add_argument("--maps", default="all", help=MAPS_HELP)
    parser.add_argument("--episodes", type=int, default=2, help="per map")
    args = parser.parse_args(words)
    if min(args.episodes, args.ticks) < 1:
        parser.error("--episodes and --ticks must be at least 1")
    try:
        pool, workers = worker_pool_of(args), workers_of(args)
        maps, partners = _maps(args.maps), partner_ids(args.partners)
        refuse_unknown([*args.agents, *partners])
        outcomes = play_all(runs(args.agents, partners, maps, args.episodes, args.ticks), workers, args.log, pool)
    except MovingOutError as error:
        parser.error(str(error))
    if args.json:
        episodes = args.episodes * len(maps)
        print(json.dumps({"partners": args.partners, "episodes": episodes, "scores": _scores(outcomes, args.agents)}))
    else:
        print(table(outcomes, args.agents, maps))


def add_options(parser: argparse.ArgumentParser, agents: list[str]) -> None:
    """Who plays, for how long and where, and what becomes of it; `agents` play if none are named."""
    parser.add_argument("--agents", nargs="+", default=agents, metavar="ID", help="agent ids")
    parser.add_argument("--ticks", type=int, default=LIMIT_TICKS)
    add_workers(parser)
    parser.add_argument("--log", type=Path, help="file of finished episodes to resume from")
    parser.add_argument("--json", action="store_true")


def partner_ids(said: str) -> list[str]:
    """The agents that a population (A, B, C), a family or an agent id stands for. Raises AgentError."""
    return [member.agent_id for member in group(f"people:{said}" if said in POPULATIONS else said)]


def refuse_unknown(agent_ids: Sequence[str]) -> None:
    """Load each agent once: fail now rather than after hours of play. Raises AgentError."""
    for agent_id in set(agent_ids):
        load_agent(agent_id)


def _maps(said: str) -> list[str]:
    """Map names. Raises MapError if one is unknown."""
    names = selected_maps(said)
    for name in names:
        load_map(name)
    return names


def _scores(outcomes: Sequence[Outcome], agents: Sequence[str]) -> dict[str, dict[str, tuple[float, float] | None]]:
    """Mean and standard error (0 for one episode) of each metric by agent; None without episodes."""
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
