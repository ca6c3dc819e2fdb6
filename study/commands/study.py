"""`movingout study`: write and check study files; what to do with the data is in study/commands/data.py."""

import argparse
import json
import shlex
from collections.abc import Callable
from contextlib import nullcontext, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from movingout.maps.commands.parser import add_out
from movingout.maps.commands.sentences import tell
from movingout.maps.files.terminal import printable_lines
from movingout.maps.spec import SEAT_COLOURS
from movingout.study.commands import backup, data
from movingout.study.commands.place import add_databases, databases
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.allocation import Visit, letters
from movingout.study.design.consent_text import unfilled
from movingout.study.design.definition import Study
from movingout.study.design.partner_speed import partners_timed
from movingout.study.design.review import Review, own_agents_tried, review
from movingout.study.design.study_file import read_study
from movingout.study.design.templates import LANGUAGES, template_names, template_text
from movingout.study.errors import StudyError, StudyFileError

_MOST_ORDERS = 12  # rows of the order table; --json has all


def configure(parser: argparse.ArgumentParser) -> "argparse._SubParsersAction[argparse.ArgumentParser]":
    """Add the commands; what comes back takes further ones."""
    commands = parser.add_subparsers(dest="action", metavar="COMMAND", required=True, title="commands")

    new = commands.add_parser(
        "new",
        help="write a commented study file to start from",
        example="movingout study new --template human_study -o study.yaml",
    )
    new.add_argument(
        "--template",
        default="human_study",
        metavar="NAME",
        help=f"one of {', '.join(template_names())} (default: %(default)s)",
    )
    known = ", ".join(LANGUAGES)
    new.add_argument("--languages", nargs="+", default=["en"], metavar="LANGUAGE", help=f"of its texts: {known} (en)")
    add_out(new, "FILE", "default: NAME.yaml; never overwritten")
    new.set_defaults(perform=_new)

    check = commands.add_parser(
        "check",
        help="timeline, duration, pay, orders, weaknesses; exit code 1 when something is missing or wrong",
        example="movingout study check study.yaml",
    )
    check.add_argument("file", type=Path, metavar="FILE", help="the study file")
    check.add_argument("--json", action="store_true", help="one JSON document on standard output")
    check.add_argument(
        "--slow-agents", action="store_true", help="for study serve --slow-agents: warn of partners that are too slow"
    )
    add_databases(check)
    check.set_defaults(perform=_check)
    data.configure(commands)
    backup.configure(commands)
    return commands


def run(args: argparse.Namespace) -> int:
    perform: Callable[[argparse.Namespace], int] = args.perform
    return perform(args)


def _new(args: argparse.Namespace) -> int:
    text = template_text(args.template, args.languages)
    output: Path = args.out or Path(f"{args.template}.yaml")
    try:
        with output.open("x", encoding="utf-8") as stream:
            stream.write(text)
    except FileExistsError:
        raise StudyError(f"{output} exists already and is not overwritten; choose another name with -o") from None
    except OSError as error:
        raise StudyError(f"cannot write {output}: {error.strerror or error}") from None
    print(f"wrote {output}; before it can be served:")
    for sentence in unfilled(read_study(output)):
        print(f"  {sentence}")
    print(f"edit it, then: movingout study check {shlex.quote(str(output))}")
    return 0


def _check(args: argparse.Namespace) -> int:
    try:
        study = read_study(args.file)
    except StudyFileError as error:
        tell(str(error))
        if args.json:
            faults = [fault._asdict() for fault in error.faults]
            print(json.dumps({"ready": False, "faults": faults}, indent=2, ensure_ascii=False))
        return 1
    found = partners_timed(own_agents_tried(review(study)))
    not_begun = (*found.refused, *found.alike, *found.slow)
    if not_begun and _has_begun(args, study):
        goes_on = f"the study {study.id} has begun: it is served all the same, and goes on as it is"
        found = replace(found, warnings=(*found.warnings, goes_on, *not_begun), refused=(), alike=(), slow=())
    if args.slow_agents:
        found = replace(found, warnings=(*found.warnings, *found.slow), slow=())
    if args.json:
        print(json.dumps(_document(found), indent=2, ensure_ascii=False))
    else:
        _print(found)
    return 0 if found.ready else 1


def _has_begun(args: argparse.Namespace, study: Study) -> bool:
    """Whether a study that has begun with this file lies where its data usually are, or where the options say.

    An empty database stays empty. Raises StudyError for a PostgreSQL database that was named and cannot be read.
    """
    folder = StudyFolder(study, args.data, *databases(args))
    with nullcontext() if folder.database else suppress(StudyError):
        return folder.has_database() and folder.has_begun_with(args.file)
    return False


def _shown(text: str) -> str:
    """For a console: a study file may come from somebody else."""
    return escape(printable_lines(text))


def _print(found: Review) -> None:
    study = found.study
    console = Console(highlight=False)
    who = f"{study.units} pairs" if study.group == 2 else f"{study.participants} participants"
    console.print(f"[bold]{_shown(study.title.text())}[/bold]  ({_shown(study.id)}), {who}", soft_wrap=True)
    table = Table(box=None, pad_edge=False)
    for column in ("step", "what", "minutes"):
        table.add_column(column, justify="right" if column == "minutes" else "left")
    for stage in found.timeline:
        table.add_row(_shown(stage.title), _shown(stage.detail), f"{stage.seconds / 60:.1f}")
    console.print(table)
    console.print(
        f"At most {found.minutes:.0f} minutes, rounds counted at their full limit.{_pay_in_words(found)}",
        soft_wrap=True,
    )
    _print_orders(console, found)
    for sentence in found.attention:
        console.print(_shown(sentence), soft_wrap=True)
    for sentence in found.warnings:
        console.print(f"[yellow]warning:[/yellow] {_shown(sentence)}", soft_wrap=True)
    for sentence in (*found.alike, *found.contradictions):
        console.print(f"[red]wrong:[/red] {_shown(sentence)}", soft_wrap=True)
    for sentence in found.slow:
        console.print(f"[red]too slow:[/red] {_shown(sentence)}", soft_wrap=True)
    for sentence in (*found.missing, *found.refused, *found.untranslated, *found.unfilled):
        console.print(f"[red]missing:[/red] {_shown(sentence)}", soft_wrap=True)
    if found.refused or found.alike or found.slow:
        begun = "one that has begun with this file is served all the same; --data or --database says where its data are"
        console.print(f"no study begins like this; {begun}", soft_wrap=True)
    counts = ", ".join(_counts(found))
    console.print(f"{'ready' if found.ready else 'not ready'}{': ' if counts else ''}{counts}", soft_wrap=True)


def _counts(found: Review) -> list[str]:
    counts = {
        "agent# that cannot play": len(found.missing) + len(found.refused),
        "agent# too slow": len(found.slow),
        "question# with equal options": len(found.alike),
        "text# missing": len(found.untranslated),
        "blank# to fill in": len(found.unfilled),
        "number# wrong": len(found.contradictions),
        "warning#": len(found.warnings),
    }
    return [f"{count} {words.replace('#', '' if count == 1 else 's')}" for words, count in counts.items() if count]


def _pay_in_words(found: Review) -> str:
    pay = found.study.pay
    if pay is None or found.pay is None:
        return " No pay is planned."
    total = found.pay * found.study.participants
    each, everybody = (f"{pay.currency} {amount:.{pay.decimals}f}" for amount in (found.pay, total))
    return f" Pay: {each} each, {everybody} for all."


def _print_orders(console: Console, found: Review) -> None:
    names = letters(found.study)
    console.print(
        "Orders of a study that begins now: maps by number with the participant's seat, B blue, R red", soft_wrap=True
    )
    table = Table(box=None, pad_edge=False)
    for column in ("slot", "block", "partner", "maps"):
        table.add_column(column)
    for order in found.orders[:_MOST_ORDERS]:
        for visit in order.visits:
            partner = names.get(visit.partner, "another participant")
            table.add_row(str(order.slot + 1), visit.block, partner, _maps_in_short(found.study, visit))
    console.print(table)
    if len(found.orders) > _MOST_ORDERS:
        console.print(f"... and {len(found.orders) - _MOST_ORDERS} more slots; --json has all", soft_wrap=True)


def _maps_in_short(study: Study, visit: Visit) -> str:
    """The maps by number, each with the seats in their order: 1B 2R, or 1BR where both are played; others by name."""
    seats: dict[str, str] = {}
    for turn in visit.turns:
        letter = SEAT_COLOURS[turn.seat][0].upper()
        known = seats.setdefault(turn.map, "")
        seats[turn.map] = known if letter in known else known + letter
    maps = {name: study.load_map(name) for name in seats}
    starts = {name: str(the_map.number) if the_map.number else f"{the_map.name}·" for name, the_map in maps.items()}
    return " ".join(starts[name] + letters for name, letters in seats.items())


def _document(found: Review) -> dict[str, Any]:
    names = letters(found.study)
    return {
        "ready": found.ready,
        "study": found.study.id,
        "title": found.study.title.text(),
        "participants": found.study.participants,
        "minutes": round(found.minutes, 2),
        "pay": found.pay,
        "timeline": [{"step": stage.title, "what": stage.detail, "seconds": stage.seconds} for stage in found.timeline],
        "orders": [
            {
                "slot": order.slot,
                "visits": [
                    {
                        "block": visit.block,
                        "partner": names.get(visit.partner, ""),
                        "rounds": [{"map": turn.map, "seat": SEAT_COLOURS[turn.seat]} for turn in visit.turns],
                    }
                    for visit in order.visits
                ],
            }
            for order in found.orders
        ],
        "partners": {names[one.id]: {"id": one.id, "agent": one.agent} for one in found.study.partners},
        "attention": list(found.attention),
        "warnings": list(found.warnings),
        "missing": [*found.missing, *found.refused],
        "slow": list(found.slow),
        "alike": list(found.alike),
        "untranslated": list(found.untranslated),
        "unfilled": list(found.unfilled),
        "contradictions": list(found.contradictions),
    }
