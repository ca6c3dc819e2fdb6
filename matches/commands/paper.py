"""`movingout paper`: the paper's tables and figures; recordings, agents and matches that they need are made first."""

import argparse
import datetime
import json
import os
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, get_args

from movingout.maps.commands.parser import add_out
from movingout.maps.commands.sentences import tell
from movingout.maps.errors import MovingOutError
from movingout.maps.suggestion import counted
from movingout.matches.commands.carry_out import carry_out
from movingout.matches.commands.dry_run import dry_run
from movingout.matches.errors import MatchError
from movingout.matches.paper.beginning import begin, begun, exclusive_folder, finish, grown
from movingout.matches.paper.budgets import BUDGETS, GROWING, budget_of
from movingout.matches.paper.data_sets import check_lists
from movingout.matches.paper.entry import PaperEntry, measurements, played_cells
from movingout.matches.paper.page.reproduction_page import write_page
from movingout.matches.paper.presentation.bar_chart import bar_chart
from movingout.matches.paper.presentation.drawing import save_drawing
from movingout.matches.paper.presentation.figure_note import figure_notes
from movingout.matches.paper.presentation.layout import laid_out
from movingout.matches.paper.presentation.writers import WRITERS
from movingout.matches.paper.registry import ENTRIES, chosen_entries
from movingout.matches.paper.steps import paper_steps
from movingout.matches.paper.training import LARGEST_SEED
from movingout.matches.paper.workspace import Evaluation, Grouping, Workspace, inside
from movingout.matches.results.results_folder import write_whole
from movingout.recordings.styles import given_styles
from movingout.world.exactness import inexact_engine

_STATES = {
    "whole": "made here", "in part": "some rows are made here", "elsewhere": "made by another command",
    "not done": "not done", "illustration": "nothing is measured",
}  # fmt: skip


def configure(parser: argparse.ArgumentParser) -> None:
    actions = parser.add_subparsers(dest="action", metavar="COMMAND", required=True, title="commands")
    listing = actions.add_parser(
        "list", help="every label, and whether it is made here", example="movingout paper list"
    )
    listing.add_argument("--json", action="store_true", help="one JSON document on standard output")
    listing.set_defaults(perform=_list)
    for name, kinds, labels in (
        ("tables", "table", "one or several of tab:…, table:…, text:… of `movingout paper list` (all)"),
        ("figures", "figure", "one or several of fig:… of `movingout paper list` (all)"),
    ):
        sub = actions.add_parser(
            name,
            help=f"make one {kinds}, several or all, beside the paper's",
            example=f"movingout paper {name} {'tab:ablation' if name == 'tables' else 'fig:results_t2'} "
            "--budget small -o data/paper",
        )
        sub.add_argument("labels", nargs="*", default=["all"], metavar="LABEL|all", help=labels)
        _making_options(sub)
        sub.set_defaults(perform=_make)
    _add_page(actions)


def _add_page(actions: Any) -> None:
    page = actions.add_parser(
        "page", help="write what a folder has measured into a page, a row per label",
        example="movingout paper page docs/reproduction.md -o data/paper",
    )  # fmt: skip
    page.add_argument("page", type=Path, metavar="PAGE", help="with the two comments between which it writes")
    add_out(page, "DIR", "folder of everything: tables, agents, matches (%(default)s)", default=Path("data/paper"))
    page.set_defaults(perform=_page)


def _page(args: argparse.Namespace) -> int:
    page = args.page.resolve()
    try:
        with inside(args.out):
            space = begun()
            check_lists(space)
            write_page(page, ENTRIES.values(), space, datetime.date.today().isoformat())
    except OSError as error:
        raise MatchError(f"there is no folder {args.out}; make tables into one first") from error
    print(f"wrote {args.page}")
    return 0


def _making_options(parser: argparse.ArgumentParser) -> None:
    add_out(parser, "DIR", "folder of everything: tables, agents, matches (%(default)s)", default=Path("data/paper"))
    parser.add_argument(
        "--data", type=Path, nargs="+", metavar="RECORDINGS", help="episodes of your people; default: scripted people"
    )
    parser.add_argument("--budget", choices=BUDGETS, default="small", help=f"{_budgets()} (default: %(default)s)")
    parser.add_argument(
        "--evaluation", choices=get_args(Evaluation), default="official",
        help="Challenge 2: evaluated on the maps as designed, as in the paper (default), or on held-out combinations",
    )  # fmt: skip
    parser.add_argument(
        "--groups", choices=get_args(Grouping), default="random",
        help="what the two groups of people are: drawn at random, as in the paper (default), or two styles of play",
    )  # fmt: skip
    parser.add_argument(
        "--styles", type=Path, metavar="FILE.csv",
        help="with --groups style: lines participant,style (default: of scripted people, their population)",
    )  # fmt: skip
    parser.add_argument("--min-tcr", type=float, default=0.0, metavar="TCR", help="leave out poorer episodes of --data")
    parser.add_argument(
        "--trainings", type=int, metavar="N",
        help="of each agent, with other seeds; may be raised in a folder later (default: of the budget)",
    )  # fmt: skip
    parser.add_argument(
        "--seeds", type=int, metavar="N",
        help="matches per pair, map and training; may be raised in a folder later (default: of the budget)",
    )  # fmt: skip
    parser.add_argument(
        "--seed", type=int, default=0, help="of everything: scripted people, groups, trainings (%(default)s)"
    )
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1, metavar="N", help="default: one per core")
    parser.add_argument("--dry-run", action="store_true", help="only say what would be done, and how long it takes")
    parser.add_argument("--json", action="store_true", help="one JSON document on standard output")


def _budgets() -> str:
    return "; ".join(
        f"{budget.name}: {budget.about.partition(';')[0].replace('%', '%%')}" for budget in BUDGETS.values()
    )


def run(args: argparse.Namespace) -> int:
    perform: Callable[[argparse.Namespace], int] = args.perform
    return perform(args)


def _list(args: argparse.Namespace) -> int:
    if args.json:
        entries = [
            {"label": entry.label, "kind": entry.kind, "title": entry.heading, "state": entry.state,
             "section": entry.published.section if entry.published else "", "why": entry.otherwise,
             "command": entry.command}
            for entry in ENTRIES.values()
        ]  # fmt: skip
        print(json.dumps({"labels": entries}, indent=2))
        return 0
    width = max(map(len, ENTRIES))
    for entry in ENTRIES.values():
        why = f": {entry.otherwise}" if entry.state == "not done" and entry.otherwise else ""
        how = f": {entry.command}" if entry.state == "elsewhere" else ""
        print(f"{entry.label:<{width}} {_STATES[entry.state]}{why}{how}\n{'':<{width}} {entry.heading}")
    return 0


def _make(args: argparse.Namespace) -> int:
    _check_numbers(args)
    entries = _entries(args)
    given, folder = _existing(args.data or ()), args.out
    styles = given_styles(args.styles, args.groups, "--groups style")
    if args.dry_run and not folder.exists():
        with tempfile.TemporaryDirectory() as empty, inside(Path(empty)):  # the current folder may be one of tables
            return dry_run(entries, _workspace(args, given, styles), args.json)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        why = "there is a file of that name" if folder.is_file() else error.strerror or error
        raise MatchError(f"cannot make the folder {folder}: {why}") from error
    with inside(folder):
        space = _workspace(args, given, styles)
        if args.dry_run:
            return dry_run(entries, space, args.json)
        with exclusive_folder():
            begin(space)
            written, failed = _made(entries, space)
    _show(args, folder, written, failed)
    return 1 if failed else 0


def _check_numbers(args: argparse.Namespace) -> None:
    if args.workers < 1 or not 0 <= args.seed <= LARGEST_SEED or not 0.0 <= args.min_tcr <= 1.0:
        raise MatchError(f"--workers is at least 1, --seed from 0 to {LARGEST_SEED:,}, and --min-tcr from 0 to 1")
    if args.min_tcr and not args.data:
        raise MatchError("--min-tcr leaves out poor episodes of --data; name recordings with --data")
    for name in GROWING:
        if (number := getattr(args, name)) is not None and number < 1:
            raise MatchError(f"--{name} is at least 1")


def _workspace(args: argparse.Namespace, given: tuple[Path, ...], styles: Mapping[str, str]) -> Workspace:
    """The workspace in the current folder."""
    budget = grown(budget_of(args.budget), trainings=args.trainings, seeds=args.seeds)
    return Workspace(
        budget=budget, evaluation=args.evaluation, workers=args.workers, seed=args.seed, given=given,
        min_tcr=args.min_tcr, grouping=args.groups, styles=tuple(sorted(styles.items())),
    )  # fmt: skip


def _entries(args: argparse.Namespace) -> list[PaperEntry]:
    """Those to make. Raises MatchError, with the reason, for a label that cannot be made here."""
    entries = chosen_entries(args.labels)
    if "all" in args.labels:
        return [entry for entry in entries if _action(entry) == args.action]
    for entry in entries:
        _check_runnable(entry)
        if (action := _action(entry)) != args.action:
            raise MatchError(f"{entry.label} is a {entry.kind}: `movingout paper {action} {entry.label}` makes it")
    return entries


def _action(entry: PaperEntry) -> str:
    """The command that makes it; a sentence with numbers becomes a table."""
    return "figures" if entry.kind == "figure" else "tables"


def _check_runnable(entry: PaperEntry) -> None:
    """Raises MatchError, with the reason, for a label that is not made here."""
    if not entry.runnable:
        why = entry.otherwise or "nothing in it is measured"
        other = f"; try: {entry.command}" if entry.command else ""
        raise MatchError(f"{entry.label} is not made by this command: {why}{other}")


def _existing(paths: Sequence[Path]) -> tuple[Path, ...]:
    for path in paths:
        if not path.exists():
            raise MatchError(f"there are no recordings at {path}")
    return tuple(dict.fromkeys(path.resolve() for path in paths))


def _made(entries: Sequence[PaperEntry], space: Workspace) -> tuple[list[Path], dict[str, str]]:
    """The files written, and why each of the other labels was not made. Raises what stops the only one.

    One label after the other: a run that is stopped leaves whole tables.
    """
    if caution := inexact_engine():
        tell(caution)
    written: list[Path] = []
    failed: dict[str, str] = {}
    for number, entry in enumerate(entries, start=1):
        where = f"{entry.label} ({number}/{len(entries)}), " if len(entries) > 1 else ""
        try:
            _check_runnable(entry)
            carry_out(paper_steps([entry], space), space, where)
            written += _write(entry, space)
            if _depends_on_numbers(entry):
                finish(space)
        except MovingOutError as error:
            if len(entries) == 1:
                raise
            failed[entry.label] = str(error)
    return written, failed


def _depends_on_numbers(entry: PaperEntry) -> bool:
    """Whether the numbers of trainings and matches make a difference to a table."""
    return bool(played_cells([entry])) or any(one.repeated for one in measurements([entry]))


def _write(entry: PaperEntry, space: Workspace) -> list[Path]:
    if entry.drawing:
        return save_drawing(entry.drawing, entry.label, entry.heading, figure_notes(entry, space), space)
    folder = Path("figures" if entry.kind == "figure" else "tables")
    table, name = laid_out(entry, space), entry.label.replace(":", "_")
    written = []
    for ending, write in WRITERS.items():
        path = folder / f"{name}.{ending}"
        write_whole(path, write(table))
        written.append(path)
    if entry.kind == "figure":
        write_whole(folder / f"{name}.svg", bar_chart(entry, space))
        written.append(folder / f"{name}.svg")
    return written


def _show(args: argparse.Namespace, folder: Path, written: Sequence[Path], failed: Mapping[str, str]) -> None:
    for label, why in failed.items():
        tell(f"{label} was not made: {why}")
    if args.json:
        document = {"files": [str(folder / path) for path in written], "not_made": failed}
        print(json.dumps(document, indent=2))
        return
    pages = [folder / path for path in written if path.suffix == ".md"]
    if len(pages) == 1:
        print(pages[0].read_text(encoding="utf-8"))
    print(f"{counted(len(pages), args.action[:-1])} in {folder}, each as Markdown, LaTeX and HTML")
