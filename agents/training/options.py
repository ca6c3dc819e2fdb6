"""The command line of a training run: one option per field of its configuration."""

import argparse
import dataclasses
from typing import Any, Literal, TypeVar, get_args, get_origin, get_type_hints

from movingout.agents.training.optimisation import Optimisation

ConfigT = TypeVar("ConfigT", bound=Optimisation)


def add_fields(parser: argparse.ArgumentParser, config: type[Optimisation]) -> None:
    """One option per field; an option that is not given is not set, so that the preset's value stays."""
    group = parser.add_argument_group("configuration (defaults come from the preset)")
    hints = get_type_hints(config)
    for entry in dataclasses.fields(config):
        if entry.name in config.UNUSED:
            continue
        group.add_argument(
            f"--{entry.name.replace('_', '-')}",
            dest=entry.name,
            default=argparse.SUPPRESS,
            help=str(entry.metadata["help"]).replace("%", "%%"),
            **_accepted(hints[entry.name]),
        )


def _accepted(hint: Any) -> dict[str, Any]:
    """argparse's arguments for a field of this type: choices, yes or no, or a number."""
    if get_origin(hint) is Literal:
        return {"choices": get_args(hint)}
    return {"type": _yes_or_no if hint is bool else hint}


def overridden(config: ConfigT, args: argparse.Namespace) -> ConfigT:
    """`config` with the options of the command line; a number of updates replaces the preset's epochs.

    Raises DataError for an invalid configuration.
    """
    given = {entry.name: vars(args)[entry.name] for entry in dataclasses.fields(config) if entry.name in vars(args)}
    if "updates" in given:
        given = {"epochs": 0} | given
    changed = dataclasses.replace(config, **given)
    changed.check()
    return changed


def _yes_or_no(word: str) -> bool:
    if word not in ("yes", "no"):
        raise argparse.ArgumentTypeError(f"yes or no, not {word!r}")
    return word == "yes"
