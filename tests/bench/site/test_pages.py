"""The generated pages of the documentation site name every command, option and field."""

import argparse

from bench.site.commands_page import commands_page
from bench.site.hooks import with_site_links
from bench.site.yaml_page import grid_page, study_page
from movingout.maps.commands.parser import parsers_below
from movingout.matches.experiment.grid import Grid
from movingout.server.cli import COMMANDS, configured
from movingout.study.design.definition import Study
from movingout.study.design.sections.consent import Consent
from movingout.study.design.sections.rounds import Block


def test_every_command_and_option_is_on_the_page() -> None:
    page = commands_page()
    for name in COMMANDS:
        for parser in parsers_below(configured(name)[1]):
            section = page.partition(f"# {parser.prog}\n")[2].partition("\n## ")[0]
            assert section, parser.prog
            for action in parser._actions:
                if action.help != argparse.SUPPRESS and not isinstance(action, argparse._HelpAction):
                    assert all(f"`{option}" in section for option in action.option_strings), (parser.prog, action)


def test_every_field_of_the_files_is_on_their_pages() -> None:
    study, grid = study_page(), grid_page()
    for model in (Study, Block, Consent):
        assert all(f"| `{field}` |" in study for field in model.model_fields)
    assert all(f"| `{field}` |" in grid for field in Grid.model_fields)
    assert "| `rounds` | whole number, 1 to 60 | `1` | per map and seat |" in study
    assert "| `maps` | list of text or `all` | `all` |  |" in grid


def test_a_link_to_a_page_stays_and_one_to_a_source_becomes_text() -> None:
    known = {"study.md", "index.md", "images/game.png", "contributing.md"}
    assert with_site_links("[a](docs/study.md#x)", "", known) == "[a](study.md#x)"
    assert with_site_links("[a](study.md)", "docs", known) == "[a](study.md)"
    assert with_site_links("![a](docs/images/game.png)", "", known) == "![a](images/game.png)"
    assert with_site_links("[a](../CONTRIBUTING.md#languages)", "docs", known) == "[a](contributing.md#languages)"
    assert with_site_links("see [env.py](../world/env.py)", "docs", known) == "see env.py"
    assert with_site_links("[a](https://mcap.dev)", "docs", known) == "[a](https://mcap.dev)"
    assert with_site_links("[a](nowhere.md)", "docs", known) == "[a](nowhere.md)"
