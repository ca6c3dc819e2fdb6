"""`movingout recordings`: each of its actions has a module of its own."""

import argparse
from collections.abc import Callable
from typing import NamedTuple, Protocol

from movingout.recordings.commands import (
    diversity,
    exports,
    failures,
    imports,
    info_page,
    listing,
    recovery,
    report,
    split,
    upload,
    verify,
    view,
)
from movingout.recordings.diversity.augmented import Recombination


class ActionModule(Protocol):
    """What the module of an action offers; `configure` sets `perform`."""

    def configure(self, parser: argparse.ArgumentParser) -> None: ...


class Action(NamedTuple):
    name: str
    module: ActionModule
    help: str
    example: str


ACTIONS = (
    Action("list", listing, "the recordings in a folder, newest first", "movingout recordings list --map HandOff"),
    Action("info", info_page, "one recording on a page", "movingout recordings info game.mcap"),
    Action(
        "verify",
        verify,
        "re-simulate and compare bit for bit; exit code 1 on a divergence",
        "movingout recordings verify data/recordings",
    ),
    Action(
        "recover",
        recovery,
        "finish what a crash left behind; save the intact part of a damaged file",
        "movingout recordings recover --data data",
    ),
    Action(
        "view",
        view,
        "look at recordings in 3D, or write one as a page",
        "movingout recordings view game.mcap",
    ),
    Action(
        "report",
        report,
        "a folder's results, heat maps and failures on one page",
        "movingout recordings report data/recordings -o report.html",
    ),
    Action(
        "failures",
        failures,
        "how often the paper's failure cases occur, by rules and as annotators confirm them",
        "movingout recordings failures data/recordings -o findings.csv",
    ),
    Action(
        "diversity",
        diversity,
        "how differently they were played: the paper's measures, and pictures of positions",
        "movingout recordings diversity data/recordings --by group -o diversity",
    ),
    Action(
        "split",
        split,
        "divide them into groups of participants, for training",
        "movingout recordings split data/recordings --groups 2 -o data/groups.csv",
    ),
    Action(
        "export",
        exports,
        "write them in another format",
        "movingout recordings export data/recordings --to parquet -o training",
    ),
    Action(
        "upload",
        upload,
        "send what a bucket of an S3-compatible store does not have yet",
        "movingout recordings upload s3://lab/study --data data",
    ),
    Action(
        "import",
        imports,
        "read official trajectories, with a report",
        "movingout recordings import trajectories -o data/official",
    ),
)


def configure(parser: argparse.ArgumentParser, recombination: Callable[[], Recombination] | None = None) -> None:
    """`recombination`, called when it is needed, offers `diversity --augmented`."""
    commands = parser.add_subparsers(dest="action", metavar="COMMAND", required=True, title="commands")
    for action in ACTIONS:
        of_action = commands.add_parser(action.name, help=action.help, example=action.example)
        if action.module is diversity:
            diversity.configure(of_action, recombination)
        else:
            action.module.configure(of_action)


def run(args: argparse.Namespace) -> int:
    """Carry out the action that was asked for."""
    perform: Callable[[argparse.Namespace], int] = args.perform
    return perform(args)
