"""The parser of all commands: every `--help` has a description and an example, and a misspelt name is recognised."""

import argparse
import difflib
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    SubParsersAction = argparse._SubParsersAction[argparse.ArgumentParser]
else:
    SubParsersAction = argparse._SubParsersAction

_EXAMPLE = "example: "


class CommandParser(argparse.ArgumentParser):
    """A parser that takes an `example`, as do the parsers of its sub-commands, whose help is their description."""

    def __init__(self, *args: Any, example: str = "", **options: Any) -> None:
        options.setdefault("formatter_class", _HelpFormatter)
        if example:
            options["epilog"] = _EXAMPLE + example
        super().__init__(*args, **options)
        self.register("action", "parsers", _Commands)

    def error(self, message: str) -> Any:
        unknown, _, given = message.partition("unrecognized arguments: ")
        if not unknown and given.startswith("-"):
            message += _question(given.split()[0].partition("=")[0], _options(self))
        super().error(message)

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is None or value in action.choices:
            return
        names = [str(choice) for choice in action.choices]
        listed = ", ".join(map(repr, action.choices))
        meant = _question(str(value), names)
        raise argparse.ArgumentError(action, f"invalid choice: {value!r} (choose from {listed}){meant}")


class _HelpFormatter(argparse.HelpFormatter):
    """Leaves the line of an example as it is, so that it can be copied."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        return text if text.startswith(_EXAMPLE) else super()._fill_text(text, width, indent)


class _Commands(SubParsersAction):
    def add_parser(self, name: str, **options: Any) -> Any:
        if description := options.get("help"):
            options.setdefault("description", f"{description[:1].upper()}{description[1:]}.")
        return super().add_parser(name, **options)


def add_out(parser: argparse.ArgumentParser, metavar: str, help: str, **options: Any) -> None:
    """Where a command writes: -o or --out. `--output`, as some commands called it once, is understood."""
    parser.add_argument("-o", "--out", type=Path, metavar=metavar, help=help, **options)
    if not options.get("required"):
        parser.add_argument("--output", dest="out", type=Path, default=argparse.SUPPRESS, help=argparse.SUPPRESS)


def parsers_below(parser: argparse.ArgumentParser) -> Iterator[argparse.ArgumentParser]:
    """A parser, and those of its sub-commands."""
    yield parser
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for name in action.choices:
                yield from parsers_below(action.choices[name])


def _options(parser: argparse.ArgumentParser) -> list[str]:
    below = (action for each in parsers_below(parser) for action in each._actions)
    return [option for action in below if action.help != argparse.SUPPRESS for option in action.option_strings]


def _question(name: str, known: Iterable[str]) -> str:
    close = difflib.get_close_matches(name, list(known), n=1)
    return f"; did you mean {close[0]}?" if close else ""
