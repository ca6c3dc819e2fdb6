"""`movingout match`: plays one pair; grids and the comparison with the paper are in modules of their own."""

import argparse
import json
import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Any

from movingout.agents.catalogue import load_agent, unseen_map
from movingout.agents.llm.model_id import outrun_cautions
from movingout.agents.partners.families import is_group, is_own, to_try
from movingout.maps import load_map
from movingout.maps.commands.map_cautions import map_cautions
from movingout.maps.commands.parser import folder
from movingout.maps.commands.sentences import tell
from movingout.maps.selection import HELP as MAPS_HELP
from movingout.maps.selection import selected_maps
from movingout.matches.commands import grid, report
from movingout.matches.commands.progress import bar
from movingout.matches.commands.worker_options import add_workers, worker_pool_of, workers_of
from movingout.matches.errors import MatchError
from movingout.matches.execution.recorder import recorded_before
from movingout.matches.experiment.plan import PlannedMatch, agent_for_seed
from movingout.matches.match import Match, MatchResult, check_numbers
from movingout.matches.results.table import MEASURES, ResultRow, copies_note, rows_of, unanswered_note
from movingout.matches.run import play_matches
from movingout.recordings.file_format.journal import JOURNAL_SUFFIX
from movingout.recordings.storage.finished import SUFFIX
from movingout.world.constants import LIMIT_TICKS, TICKS_PER_SECOND
from movingout.world.estimates import estimate_text
from movingout.world.exactness import inexact_engine


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--red", metavar="AGENT", help="agent id, package.module:Factory, people:C, family:greedy or @FILE"
    )
    parser.add_argument("--blue", metavar="AGENT", help="who plays blue, as --red")
    parser.add_argument("--map", default="all", metavar="NAME|all", help=f"{MAPS_HELP}; default: all")
    parser.add_argument("--episodes", type=int, default=1, help="per map; default 1")
    parser.add_argument("--seed", type=int, default=0, help="seed of the first episode; the others count up from it")
    parser.add_argument(
        "--challenge", type=int, choices=(1, 2), default=1, help="2: items not seen in training (default %(default)s)"
    )
    parser.add_argument(
        "--ticks",
        type=int,
        default=LIMIT_TICKS,
        help=f"limit of an episode, {TICKS_PER_SECOND} per second (%(default)s)",
    )
    add_workers(parser)
    parser.add_argument("--record", type=folder, metavar="DIR", help="write each match as a recording")
    parser.add_argument("--json", action="store_true", help="one JSON document on standard output")
    parser.set_defaults(perform=_pair)
    actions = parser.add_subparsers(metavar="COMMAND", title="more")
    grid.configure(
        actions.add_parser(
            "grid",
            help="play a grid of agents, maps and seeds; can be resumed",
            example="movingout match grid challenge-1 --dry-run",
        )
    )
    report.configure(
        actions.add_parser(
            "report",
            help="compare results with the paper's tables",
            example="movingout match report data/matches/challenge-1",
        )
    )


def run(args: argparse.Namespace) -> int:
    perform: Callable[[argparse.Namespace], int] = args.perform
    return perform(args)


def _pair(args: argparse.Namespace) -> int:
    before = _recorded(args.record)
    try:
        return _play_pair(args)
    except KeyboardInterrupt:
        new = _recorded(args.record) - before
        if not new:
            raise
        unfinished = any(path.name.endswith(JOURNAL_SUFFIX) for path in new)
        finish = f"; finish it with: movingout recordings recover {shlex.quote(str(args.record))}" if unfinished else ""
        tell(f"stopped; what was recorded until then is in {args.record}{finish}")
        return 130


def _recorded(folder: Path | None) -> set[Path]:
    """Recordings and journals in a folder, which need not be there."""
    return set() if folder is None else {path for end in (SUFFIX, JOURNAL_SUFFIX) for path in folder.glob(f"*{end}")}


def _play_pair(args: argparse.Namespace) -> int:
    plan, pool = _plan(args), worker_pool_of(args)
    if caution := inexact_engine():
        tell(caution)
    matches = [entry.match for entry in plan]
    for caution in [*map_cautions(match.map for match in matches), *cautions(matches)]:
        tell(caution)
    with bar("matches") as progress:
        results = play_matches(
            [entry.match for entry in plan], workers=workers_of(args), record=args.record, pool=pool,
            progress=progress,
        )  # fmt: skip
    found = dict(zip((entry.match for entry in plan), results, strict=True))
    rows = [row for row in rows_of(plan, found) if row.map in {entry.match.map for entry in plan}]
    if args.json:
        document = {
            "seed": args.seed,
            "ticks": args.ticks,
            "challenge": args.challenge,
            "results": [_row_json(row.to_json()) for row in rows],
            "failures": [_failure_json(result) for result in results if result.ending == "failed"],
            "recordings": [result.recording for result in results if result.recording],
        }
        print(json.dumps(document, indent=2))
    else:
        print(_table(args.blue, args.red, rows_of(plan, found)))
    if note := recorded_before(results):
        tell(note)
    lost = failure_lines(results)
    for line in lost:
        tell(line)
    return 1 if lost else 0  # a grid counts failed matches and goes on


def _plan(args: argparse.Namespace) -> list[PlannedMatch]:
    if args.blue is None or args.red is None:
        raise MatchError("name both agents, as in: movingout match --blue scripted --red idle --map HandOff")
    try:
        check_numbers(args.episodes, args.seed, args.ticks, args.challenge)
    except MatchError as error:
        raise MatchError(f"--{error}") from None
    names = selected_maps(args.map)
    for name in names:
        load_map(name)
    same = args.blue == args.red
    for agent_id in (args.blue, args.red):
        if is_group(agent_id):
            agent_for_seed(agent_id, 0)
        if is_own(agent_id):
            for one in to_try(agent_id):
                load_agent(one)
    return [
        PlannedMatch("", args.blue, args.red, 0, Match(
            map=name, blue=agent_for_seed(args.blue, seed), red=agent_for_seed(args.red, seed, other=same),
            seed=seed, challenge=args.challenge, ticks=args.ticks,
        ))
        for name in names
        for seed in range(args.seed, args.seed + args.episodes)
    ]  # fmt: skip


def _row_json(row: dict[str, Any]) -> dict[str, Any]:
    """The documented fields of `match --json`, and more."""
    rest = {name: value for name, value in row.items() if name not in ("condition", "challenge", "agent", "partner")}
    return {"map": row["map"], "blue": row["agent"], "red": row["partner"], **rest, "wt": row["wt_s"]}


def _failure_json(result: MatchResult) -> dict[str, Any]:
    match = result.match
    return {"map": match.map, "seed": match.seed, "seat": result.failed_seat, "tick": result.ticks,
            "reason": result.failure}  # fmt: skip


def cautions(matches: list[Match]) -> list[str]:
    """A sentence for each trained agent and map that it was not trained on, and for models that a match outruns."""
    seated_on = dict.fromkeys((agent_id, match.map) for match in matches for agent_id in match.seats)
    found = [caution for agent_id, name in seated_on if (caution := unseen_map(agent_id, load_map(name).name))]
    return [*found, *outrun_cautions(agent_id for agent_id, _ in seated_on)]


def failure_lines(results: list[MatchResult]) -> list[str]:
    """The reasons of failed matches, at most five, and how many more there are."""
    failed = [result for result in results if result.ending == "failed"]
    lines = [f"{one.match.map}, seed {one.match.seed}: failed: {one.failure}" for one in failed[:5]]
    return [*lines, *([f"and {len(failed) - 5} more failed matches"] if len(failed) > 5 else [])]


_LEGEND = (
    f"all home: episodes that delivered everything; {'; '.join(f'{m.heading}: {m.title.lower()}' for m in MEASURES)}"
)


def _table(blue: str, red: str, rows: list[ResultRow]) -> str:
    heads = ["map", "episodes", "all home", *(measure.heading for measure in MEASURES)]
    lines = [heads]
    for row in rows:
        full = sum(result.ending == "delivered" for result in row.results)
        lines.append([row.map, row.count_text, str(full), *(estimate_text(row.estimate(m)) for m in MEASURES)])
    widths = [max(len(line[k]) for line in lines) for k in range(len(heads))]
    table = "\n".join("  ".join(map(str.ljust, line, widths)).rstrip() for line in lines)
    notes = copies_note(rows) + unanswered_note(rows)
    return "\n\n".join([f"blue {blue}, red {red}; means ± standard errors", table, _LEGEND, *notes])
