"""Command-line options made from the fields of a frozen dataclass: each is declared once, with its default and help.

A field made with `option` may be given on the command line; `add_options` makes the argparse options, and
`values_of` what was given, by field.
"""

import argparse
from collections.abc import Callable, Collection
from dataclasses import Field, field, fields
from typing import Any, NamedTuple

_KEY = "option"


class Option(NamedTuple):
    """How a field is called and explained on the command line."""

    flag: str
    help: str  # "(%(default)s)" is filled in
    metavar: str | None
    parse: Callable[[str], Any] | None  # None for a switch
    repeatable: bool  # the field is a tuple
    default: Any


def option(
    default: Any,
    help: str,
    *,
    flag: str = "",
    metavar: str | None = None,
    parse: Callable[[str], Any] | None = str,
    offered: Any = None,
) -> Any:
    """A dataclass field that is also an option.

    `flag` is `--name-of-the-field` unless given. A field with a tuple as default may be given several times. Commands
    offer `offered` as default instead of the field's own, where it is given.
    """
    repeatable = isinstance(default, tuple)
    shown = default if offered is None else offered
    return field(
        default=default,
        metadata={
            _KEY: Option(flag=flag, help=help, metavar=metavar, parse=parse, repeatable=repeatable, default=shown)
        },
    )


def add_options(parser: argparse.ArgumentParser, declared: type, without: Collection[str] = ()) -> None:
    """An option for each field of `declared` that has one, in order, but for the fields in `without`."""
    for each in fields(declared):
        if _KEY in each.metadata and each.name not in without:
            _add(parser, each, each.metadata[_KEY])


def values_of(args: argparse.Namespace, declared: type) -> dict[str, Any]:
    """The fields of `declared` that the parser has options for, as they were given."""
    given = {each.name: getattr(args, each.name) for each in fields(declared) if hasattr(args, each.name)}
    return {name: tuple(value) if isinstance(value, list) else value for name, value in given.items()}


def _add(parser: argparse.ArgumentParser, declared: "Field[Any]", given: Option) -> None:
    flag = given.flag or "--" + declared.name.replace("_", "-")
    if given.parse is None:
        parser.add_argument(flag, dest=declared.name, action="store_true", help=given.help)
        return
    how: dict[str, Any] = {"action": "append", "default": []} if given.repeatable else {"default": given.default}
    if given.default == "":  # or argparse would parse it, and refuse an empty value that nobody has given
        how["default"] = argparse.SUPPRESS
    parser.add_argument(flag, dest=declared.name, type=given.parse, metavar=given.metavar, help=given.help, **how)
