"""Every `movingout` command in a block of the documentation is one that the program understands."""

import re
import shlex
from pathlib import Path

import pytest

from movingout.server.cli import configured
from tests.support import ROOT

PAGES = sorted((ROOT / "docs").glob("*.md"))
FENCED = re.compile(r"^```\w*\n(.*?)^```", re.MULTILINE | re.DOTALL)
INDENTED = re.compile(r"^ {4}(movingout .*)$", re.MULTILINE)
STARTS = ("movingout ", ".venv/bin/movingout ")
SHELL = {"|", "&&", ">", "&", ";"}


def commands_of(text: str) -> list[list[str]]:
    """The words after `movingout` of each command in a block, up to where the shell has another one."""
    blocks = "\n".join([*FENCED.findall(text), *INDENTED.findall(text)]).replace("\\\n", " ")
    lines = [shlex.split(line, comments=True)[1:] for line in blocks.splitlines() if line.startswith(STARTS)]
    return [words[: next((at for at, word in enumerate(words) if word in SHELL), len(words))] for words in lines]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_the_program_understands_each_command(page: Path, capsys: pytest.CaptureFixture[str]) -> None:
    refused = []
    for words in commands_of(page.read_text(encoding="utf-8")):
        try:
            configured(words[0])[1].parse_args(words[1:])
        except SystemExit as end:
            if end.code:
                refused.append((" ".join(words), capsys.readouterr().err))
    assert refused == []


def test_a_command_that_is_wrong_is_found(capsys: pytest.CaptureFixture[str]) -> None:
    (words,) = commands_of("```sh\n.venv/bin/movingout study new rehearsal.yaml --template collect  # a file\n```\n")
    assert words == ["study", "new", "rehearsal.yaml", "--template", "collect"]
    with pytest.raises(SystemExit):
        configured(words[0])[1].parse_args(words[1:])
    assert "unexpected: rehearsal.yaml" in capsys.readouterr().err
