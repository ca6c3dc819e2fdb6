"""`movingout agents weakness AGENT`: the partners of a generative model with which an agent does worst."""

import argparse
import json
import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Column, Table

from movingout.agents.catalogue import load_agent
from movingout.agents.checkpoint.checkpoint import find_checkpoint, model_roots
from movingout.agents.data.rollout import check_undelivered
from movingout.agents.errors import AgentError
from movingout.agents.generative.latent_option import latent_text
from movingout.agents.generative.trials import Occasion, Stage, stage
from movingout.agents.generative.weakness import SearchPlan, search, within
from movingout.agents.partners.families import LATENT_MODEL
from movingout.maps import load_map
from movingout.maps.commands.parser import add_out
from movingout.maps.selection import HELP as MAPS_HELP
from movingout.maps.selection import selected_maps
from movingout.world.constants import LIMIT_TICKS
from movingout.world.estimates import estimate, estimate_text
from movingout.world.state import Floats

CONTROL = "idle"
_FRESH = 1_000_003  # from the seeds of the search to those with which its finds are measured again


@dataclass(frozen=True, slots=True)
class Measured:
    """A partner, and the TCR of the agent and of an idle one beside it, episode by episode."""

    partner: str
    mine: list[float]
    idle: list[float]

    @property
    def gains(self) -> list[float]:
        """What the agent adds to an idle one."""
        return [mine - idle for mine, idle in zip(self.mine, self.idle, strict=True)]


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("agent", metavar="ID", help="the agent whose weakness is looked for")
    parser.add_argument("--partner", default=LATENT_MODEL, metavar="ID", help="the model of partners (%(default)s)")
    parser.add_argument("--map", default="all", help=f"{MAPS_HELP}; default: all")
    parser.add_argument(
        "--minimise", choices=("gain", "tcr"), default="gain",
        help="gain (default): the agent's TCR less that of an idle one beside the same partner; tcr: the TCR itself, "
        "which finds partners that do little",
    )  # fmt: skip
    parser.add_argument("--rounds", type=int, default=6, help="of the search (%(default)s)")
    parser.add_argument("--candidates", type=int, default=12, help="partners in a round (%(default)s)")
    parser.add_argument("--episodes", type=int, default=12, help="with each partner; maps in turn (%(default)s)")
    parser.add_argument("--radius", type=float, default=3.0, help="longest latent (%(default)s)")
    parser.add_argument("--worst", type=int, default=5, help="how many are measured again and named (%(default)s)")
    parser.add_argument("--ticks", type=int, default=LIMIT_TICKS, help="limit of an episode (%(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="seed of the search and of its episodes (%(default)s)")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1, help="processes (default: all cores)")
    add_out(parser, "FILE", "write the ids of the worst partners, one a line")
    parser.add_argument("--json", action="store_true", help="one JSON document on standard output")


def perform(args: argparse.Namespace) -> int:
    """Search, measure the finds again beside as many random partners, print and write them. Raises AgentError."""
    plan, occasion = _checked(args)
    random = np.random.default_rng(args.seed)
    with stage(args.workers) as players:

        def score(number: int, latents: Sequence[Floats]) -> list[float]:
            seed = args.seed + number * args.episodes
            tried = _measured(args, players, occasion, [_id(args, latent) for latent in latents], seed)
            scores = [float(np.mean(one.mine if args.minimise == "tcr" else one.gains)) for one in tried]
            print(
                f"round {number + 1} of {plan.rounds}: {args.minimise} {np.mean(scores):.3f}, worst {min(scores):.3f}",
                file=sys.stderr,
            )
            return scores

        found = search(plan, score, random)[: args.worst]
        drawn = within(random.standard_normal((len(found), plan.size)), plan.radius)
        ids = [_id(args, one.latent) for one in found], [_id(args, latent) for latent in drawn]
        seed = args.seed + _FRESH
        worst, usual = (_measured(args, players, occasion, group, seed) for group in ids)
    _print(args, worst, usual)
    if args.out is not None:
        _write(args.out, worst)
    return 0


def _checked(args: argparse.Namespace) -> tuple[SearchPlan, Occasion]:
    """What is searched and played. Raises AgentError, CheckpointError or MapError before anything is played."""
    size = find_checkpoint(args.partner, *model_roots()).card.network.latent
    if not size:
        raise AgentError(f"{args.partner} has no latent to search; `movingout train latent` makes such models")
    if min(args.episodes, args.ticks, args.worst) < 1:
        raise AgentError("--episodes, --ticks and --worst must be at least 1")
    if args.seed < 0:
        raise AgentError(f"--seed is a whole number from 0 on, not {args.seed}")
    plan = SearchPlan(size, args.rounds, args.candidates, args.radius)
    plan.check()
    load_agent(args.agent)
    maps = tuple(selected_maps(args.map))
    for name in maps:
        check_undelivered(load_map(name))
    if args.out is not None:
        _check_writable(args.out)
    return plan, Occasion(maps, args.episodes, args.ticks)


def _id(args: argparse.Namespace, latent: Floats) -> str:
    return f"{args.partner}:z={latent_text(latent)}"


def _measured(
    args: argparse.Namespace, players: Stage, occasion: Occasion, partners: Sequence[str], seed: int
) -> list[Measured]:
    """The agent and an idle one with each partner, on the same maps and seeds."""
    trials = [
        trial for partner in partners for who in (args.agent, CONTROL) for trial in occasion.trials(who, partner, seed)
    ]
    rates = np.array(players.completions(trials)).reshape(len(partners), 2, occasion.episodes)
    return [Measured(partner, *both.tolist()) for partner, both in zip(partners, rates, strict=True)]


def _print(args: argparse.Namespace, worst: Sequence[Measured], usual: Sequence[Measured]) -> None:
    rows = [(one.partner, [one]) for one in worst]
    rows += [(f"the worst {len(worst)}", list(worst)), (f"{len(usual)} drawn at random", list(usual))]
    if args.json:
        document = [{"partner": one.partner, "tcr": one.mine, "idle": one.idle} for one in (*worst, *usual)]
        print(json.dumps({"agent": args.agent, "worst": document[: len(worst)], "random": document[len(worst) :]}))
        return
    table = Table(
        Column("partner", overflow="fold"), f"TCR of {args.agent}", "TCR of idle", "gain", box=None, header_style="dim"
    )
    for name, group in rows:
        columns = [[value for one in group for value in part(one)] for part in (_mine, _idle, _gains)]
        table.add_row(name, *(estimate_text(estimate(values)) for values in columns))
    Console(highlight=False, markup=False, soft_wrap=True).print(table)


def _mine(one: Measured) -> list[float]:
    return one.mine


def _idle(one: Measured) -> list[float]:
    return one.idle


def _gains(one: Measured) -> list[float]:
    return one.gains


def _check_writable(path: Path) -> None:
    """Before hours of search. What is in the file stays until there is something better."""
    with _writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        fresh = not path.exists()
        with path.open("a", encoding="utf-8"):
            pass
        if fresh:
            path.unlink()


def _write(path: Path, worst: Sequence[Measured]) -> None:
    with _writing(path):
        path.write_text("".join(f"{one.partner}\n" for one in worst), encoding="utf-8")
    print(f"wrote {path}", file=sys.stderr)


@contextmanager
def _writing(path: Path) -> Iterator[None]:
    """Raises AgentError when the file cannot be written."""
    try:
        yield
    except OSError as error:
        raise AgentError(f"cannot write {path}: {error.strerror or error}") from error
