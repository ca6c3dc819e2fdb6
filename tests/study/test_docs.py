"""The page about studies names every field and every command that there is."""

import argparse
import re
from pathlib import Path

import pytest

from movingout.maps.commands.parser import CommandParser
from movingout.server.study.commands import study
from movingout.study.design.definition import Study
from movingout.study.design.sections.rounds import Block
from movingout.study.design.templates import template_names

PAGE = (Path(__file__).parents[2] / "docs" / "study.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", [*Study.model_fields, *Block.model_fields, *template_names()])
def test_every_field_and_template_is_explained(name: str) -> None:
    assert name == "id" or f"`{name}" in PAGE


def test_every_command_is_shown_and_every_shown_one_exists() -> None:
    parser = CommandParser()
    study.configure(parser)
    (choices,) = [action.choices for action in parser._actions if isinstance(action, argparse._SubParsersAction)]
    assert set(re.findall(r"^movingout study (\w+)", PAGE, re.MULTILINE)) == set(choices)
    without = {name for name, command in choices.items() if "--json" not in command.format_help()}
    assert without == {"new", "serve"} and "All but `new` and `serve` take `--json`" in PAGE
