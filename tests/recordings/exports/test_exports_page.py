"""docs/exports.md: it names every format and every option."""

import argparse

from movingout.recordings.commands import exports
from movingout.recordings.exports import FORMATS
from movingout.recordings.imports.sources import SUFFIXES
from tests.support import ROOT

PAGE = (ROOT / "docs" / "exports.md").read_text(encoding="utf-8")


def test_the_page_names_every_format_and_its_extra() -> None:
    for name, chosen in FORMATS.items():
        assert f"`{name}`" in PAGE
        assert not chosen.extra or f"`{chosen.extra}`" in PAGE


def test_every_option_on_the_page_exists() -> None:
    parser = argparse.ArgumentParser()
    exports.configure(parser)
    options = {option for action in parser._actions for option in action.option_strings}
    for option in ("--to", "--out", "--test-share", "--view", "--layout", "--speed", "--every", "--no-overlay"):
        assert option in options
        assert option in PAGE


def test_the_page_names_every_kind_of_file_that_is_imported() -> None:
    for suffix in SUFFIXES:
        assert f"`{suffix}`" in PAGE
