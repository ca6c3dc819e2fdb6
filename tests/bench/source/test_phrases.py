"""The list of files in docs/architecture.md."""

from pathlib import Path

from bench.source.files import ROOT
from bench.source.phrases import PAGE, START, phrase, section


def test_the_page_lists_every_file_as_it_describes_itself() -> None:
    listed = START + PAGE.read_text(encoding="utf-8").partition(START)[2]
    assert listed == section(ROOT), "run: python -m bench.source.phrases"


def test_every_file_says_in_a_phrase_what_it_is() -> None:
    assert not [line for line in section(ROOT).splitlines() if line.startswith("- ") and line.endswith(": ")]


def test_a_phrase_is_the_first_sentence_of_docstring_or_comment(tmp_path: Path) -> None:
    files = {
        "a.py": ('"""Walls,\nand floors. Nothing else.\n\nMore.\n"""\n', "Walls, and floors"),
        "b.js": ("// @ts-check\n/*\n * What is drawn: all of it.\n */\n", "What is drawn: all of it"),
        "c.js": ("// The clock,\n// in ms. Pure.\nimport x;\n", "The clock, in ms"),
        "d.py": ("x = 1\n", ""),
    }
    for name, (text, expected) in files.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
        assert phrase(tmp_path / name) == expected
