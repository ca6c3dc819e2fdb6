"""Whoever gives a password in the address of a database is told that others can read it, in every command."""

from pathlib import Path

import pytest

from movingout.server.cli import main
from movingout.server.security.passwords import PASSWORD_SEEN

WITH, WITHOUT = "postgresql://me:secret@127.0.0.1:1/x", "postgresql://me@127.0.0.1:1/x"
COMMANDS = [
    *(["study", action, "none.yaml", "--database"] for action in ("serve", "report", "export", "backup", "purge")),
    ["study", "forget", "none.yaml", "P1", "--identities"],
    ["study", "restore", "none", "--cluster"],
    ["study", "serve", "none.yaml", "--cluster"],
    ["play", "--cluster"],
    ["cluster", "status", "--cluster"],
]


@pytest.mark.parametrize("command", COMMANDS, ids=lambda words: " ".join(words))
def test_every_command_warns_once(
    command: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main([*command, WITHOUT]) == 2
    assert PASSWORD_SEEN not in capsys.readouterr().err
    for address in (WITH, f"{WITHOUT}?password=secret"):
        assert main([*command, address]) == 2, "nothing is there"
        assert capsys.readouterr().err.count(PASSWORD_SEEN) == 1


def test_what_is_no_address_is_said_by_the_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["cluster", "status", "--cluster", "http://[nonsense"]) == 2
    assert PASSWORD_SEEN not in capsys.readouterr().err
