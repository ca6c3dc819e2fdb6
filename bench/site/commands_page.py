"""The page of all commands, written from their parsers."""

import argparse
from collections.abc import Iterator

from movingout.maps.commands.parser import parsers_below
from movingout.server.cli import COMMANDS, configured


def commands_page() -> str:
    """Markdown: a chapter per command, with its sub-commands and all options."""
    lines = ["# Commands", "", "What `--help` says, on one page."]
    for name in COMMANDS:
        _, parser = configured(name)
        for one in parsers_below(parser):
            lines += _section(one, depth=2 if one is parser else 3)
    return "\n".join(lines) + "\n"


def _section(parser: argparse.ArgumentParser, depth: int) -> Iterator[str]:
    yield from ("", f"{'#' * depth} {parser.prog}", "", _plain(parser.description or ""))
    if parser.epilog:
        yield from ("", f"    {parser.epilog.removeprefix('example: ')}")
    rows = [_row(parser, action) for action in parser._actions if _is_shown(action)]
    if rows:
        yield from ("", "| argument | meaning | default |", "|---|---|---|", *rows)


def _is_shown(action: argparse.Action) -> bool:
    return action.help != argparse.SUPPRESS and not isinstance(
        action, argparse._HelpAction | argparse._SubParsersAction
    )


def _row(parser: argparse.ArgumentParser, action: argparse.Action) -> str:
    formatter = parser._get_formatter()
    value = formatter._format_args(action, formatter._get_default_metavar_for_optional(action)).strip()
    names = [f"{option} {value}".strip() for option in action.option_strings] or [value]
    required = " (required)" if action.required and action.option_strings else ""
    meaning = _plain(formatter._expand_help(action) if action.help else "")
    return f"| {', '.join(f'`{_cell(name)}`' for name in names)}{required} | {meaning} | {_default(action)} |"


def _default(action: argparse.Action) -> str:
    """Empty where there is none, where it is "no", and where the help says it."""
    if action.default in (None, False, argparse.SUPPRESS, []) or action.required:
        return ""
    if f"({action.default})" in (action.help or ""):
        return ""
    values = action.default if isinstance(action.default, list | tuple) else [action.default]
    return f"`{_cell(' '.join(map(str, values)))}`"


def _plain(text: str) -> str:
    """Text of a parser as Markdown: what would be markup stays as it is."""
    return _cell(" ".join(text.split())).replace("<", "&lt;").replace("*", r"\*").replace("_", r"\_")


def _cell(text: str) -> str:
    return text.replace("|", r"\|")
