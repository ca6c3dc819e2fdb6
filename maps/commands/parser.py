"""The parser of all commands: every `--help` has a description and an example; what is wrong is said in a sentence.

Readers of options raise ArgumentTypeError.
"""

import argparse
import re
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from movingout.maps.suggestion import known_names, probably_meant

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

    def error(self, message: str) -> NoReturn:
        """End with exit code 2, the fault in one sentence, and where the options are explained."""
        self.exit(2, f"{self.prog}: {self._sentence(message)}\nFor help: {self.prog} --help\n")

    def _print_message(self, message: str, file: Any = None) -> None:
        """Print; argparse drops what cannot be written. Raises OSError where that is standard output."""
        if message and file is sys.stdout:
            file.write(message)
        else:
            super()._print_message(message, file)

    def _sentence(self, message: str) -> str:
        """What argparse says, in words for people."""
        kind, _, given = message.partition(": ")
        if kind == "unrecognized arguments":
            return self._superfluous(given)
        if kind == "the following arguments are required":
            return self._missing(given)
        plain = message.removeprefix("argument ")
        for form, words in _PLAINER:
            plain = form.sub(words, plain)
        return plain

    def _superfluous(self, given: str) -> str:
        first = given.split()[0].partition("=")[0]
        if not first.startswith("-"):
            writes = any("-o" in action.option_strings for action in self._actions)
            return f"unexpected: {given}" + (f" (a file or folder to write is named by -o {first})" if writes else "")
        shown = (action.option_strings for action in self._actions if action.help != argparse.SUPPRESS)
        return f"unknown option {first}{probably_meant(first, [option for options in shown for option in options])}"

    def _missing(self, given: str) -> str:
        for action in self._actions:
            if isinstance(action, argparse._SubParsersAction) and action.metavar == given:
                return f"name one of: {', '.join(action.choices)}"
        return f"missing: {given}"

    def parse_known_args(  # type: ignore[override]
        self, args: Sequence[str] | None = None, namespace: Any = None
    ) -> tuple[Any, list[str]]:
        self._given = list(args or [])
        return super().parse_known_args(args, namespace)

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is None or value in action.choices:
            return
        known = known_names(str(value), map(str, action.choices))
        if not isinstance(action, argparse._SubParsersAction):
            raise argparse.ArgumentError(action, f"unknown value {value!r}; {known}")
        for word in self._given[: self._given.index(value)]:
            if word.startswith("--") and not self._get_option_tuples(word):  # then `value` was meant as its value
                self.error(f"unrecognized arguments: {word}")
        raise argparse.ArgumentError(None, f"unknown {str(action.metavar).lower()} {value!r}; {known}")


# How argparse words a wrong value, and what is said instead.
_PLAINER = (
    (re.compile(r"invalid int value: ('.*')"), r"\1 is not a whole number"),
    (re.compile(r"invalid float value: ('.*')"), r"\1 is not a number"),
    (re.compile(r"expected (?:one|at least one) argument"), "a value is missing"),
)


class _HelpFormatter(argparse.HelpFormatter):
    """Leaves the line of an example as it is, so that it can be copied."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        return text if text.startswith(_EXAMPLE) else super()._fill_text(text, width, indent)


class _Commands(SubParsersAction):
    def add_parser(self, name: str, **options: Any) -> Any:
        if description := options.get("help"):
            options.setdefault("description", f"{description[:1].upper()}{description[1:]}.")
        return super().add_parser(name, **options)

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: str | Sequence[Any] | None,
        option_string: str | None = None,
    ) -> None:
        super().__call__(parser, namespace, values, option_string)
        if isinstance(values, list) and (unknown := getattr(namespace, argparse._UNRECOGNIZED_ARGS_ATTR, None)):
            self.choices[values[0]].error(f"unrecognized arguments: {' '.join(unknown)}")


def filled(text: str) -> str:
    """A value that is not empty, as an unset variable is: with it, the option would mean nothing without a word."""
    if not text.strip():
        raise argparse.ArgumentTypeError("the value is empty; give one, or leave the option out")
    return text


def folder(text: str) -> Path:
    """A folder. An empty one, as of an unset variable, would be whichever the command was started in."""
    if not text.strip():
        raise argparse.ArgumentTypeError("name a folder; the current one is .")
    return Path(text)


def output_place(text: str) -> Path:
    """A file or folder to be written. An empty name, as of an unset variable, would be the current folder."""
    if not text.strip():
        raise argparse.ArgumentTypeError("name a file or folder; the current folder is .")
    return Path(text)


def add_out(parser: argparse.ArgumentParser, metavar: str, help: str, **options: Any) -> None:
    """Where a command writes: -o or --out. `--output`, as some commands called it once, is understood."""
    parser.add_argument("-o", "--out", type=output_place, metavar=metavar, help=help, **options)
    if not options.get("required"):
        parser.add_argument(
            "--output", dest="out", type=output_place, default=argparse.SUPPRESS, help=argparse.SUPPRESS
        )


def add_json(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="one JSON document on standard output")


def parsers_below(parser: argparse.ArgumentParser) -> Iterator[argparse.ArgumentParser]:
    """A parser, and those of its sub-commands."""
    yield parser
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for name in action.choices:
                yield from parsers_below(action.choices[name])
