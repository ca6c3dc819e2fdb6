"""`movingout demos …`: demonstrations by scripted people, as training data."""

import argparse
from collections.abc import Callable

from movingout.agents.commands.demonstrations import generate, label, people, prove
from movingout.recordings.commands import imports


def configure(parser: argparse.ArgumentParser) -> None:
    """`generate`, `label`, `prove`, `import` and `people`."""
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    generate.configure(
        actions.add_parser(
            "generate",
            help="record pairs of scripted people",
            example="movingout demos generate --population A --people 4 -o data/demos",
        )
    )
    label.configure(
        actions.add_parser(
            "label",
            help="let an expert label what a learner does (DAgger)",
            example="movingout demos label --learner dp@mine -o data/corrections",
        )
    )
    prove.configure(
        actions.add_parser(
            "prove",
            help="list generated maps on which a pair of experts delivers everything",
            example="movingout demos prove --split training --count 1000 -o data/maps.txt",
        )
    )
    imports.configure(
        actions.add_parser(
            "import",
            help="import official trajectories (same as `recordings import`)",
            example="movingout demos import trajectories -o data/official",
        )
    )
    people.configure(
        actions.add_parser(
            "people", help="list the scripted people and the families of partners", example="movingout demos people"
        )
    )


def run(args: argparse.Namespace) -> int:
    """Carry out the action that was asked for."""
    perform: Callable[[argparse.Namespace], int] = args.perform
    return perform(args)
