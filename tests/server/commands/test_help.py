"""Every `--help` has a description and an example that works; misspelt names are recognised; completion is a script."""

import argparse
import importlib
import os
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from movingout.maps.commands.parser import parsers_below
from movingout.maps.randomize import SPLITS
from movingout.server.cli import COMMANDS, configured, main
from tests.support import ROOT


def every_parser() -> Iterator[argparse.ArgumentParser]:
    for name in COMMANDS:
        yield from parsers_below(configured(name)[1])


PARSERS = {parser.prog: parser for parser in every_parser()}
WITH_ACTIONS = {
    "movingout agents",
    "movingout cluster",
    "movingout demos",
    "movingout maps",
    "movingout recordings",
    "movingout study",
}


@pytest.mark.parametrize("prog", PARSERS)
def test_help_has_a_description_and_an_example_that_can_be_typed(prog: str) -> None:
    parser = PARSERS[prog]
    assert parser.description and parser.description.endswith(".")
    assert parser.epilog and parser.epilog in parser.format_help()
    program, command, *arguments = shlex.split(parser.epilog.removeprefix("example: ").partition(" > ")[0])
    assert program == "movingout" and f"{program} {command}" in prog + " "
    if "--help" not in arguments:
        configured(command)[1].parse_args(arguments)


@pytest.mark.parametrize("prog", PARSERS)
def test_every_option_says_what_it_is_and_what_it_is_without_being_given(prog: str) -> None:
    for action in PARSERS[prog]._actions:
        if action.help == argparse.SUPPRESS or isinstance(action, argparse._SubParsersAction):
            continue
        assert action.help, f"{prog} {action.option_strings or action.dest} has no help"
        given = action.required or action.nargs == 0 or action.default == argparse.SUPPRESS or not action.default
        text = PARSERS[prog]._get_formatter()._expand_help(action)
        said = "default" in text or f"({_shown(action.default)}" in text
        assert given or said, f"{prog} {action.option_strings or action.dest} does not say its default: {text}"


def _shown(default: object) -> str:
    if isinstance(default, list | tuple):
        return ", ".join(map(_shown, default))
    return f"{default:g}" if isinstance(default, float) else str(default)


@pytest.mark.parametrize("prog", PARSERS)
def test_what_is_written_goes_to_out(prog: str) -> None:
    shown = [
        option for action in PARSERS[prog]._actions for option in action.option_strings if action.help != "==SUPPRESS=="
    ]
    assert "--output" not in shown
    assert ("-o" in shown) == ("--out" in shown)


def test_the_former_name_of_out_is_understood(tmp_path: Path) -> None:
    assert main(["maps", "render", "HandOff", "--output", str(tmp_path / "a.svg")]) == 0
    assert main(["maps", "render", "HandOff", "--out", str(tmp_path / "b.svg")]) == 0
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        (["mpas", "list"], "did you mean maps?"),
        (["maps", "lst"], "did you mean list?"),
        (["maps", "render", "HandOff", "--theme", "drak"], "did you mean dark?"),
        (["maps", "list", "--jsn"], "did you mean --json?"),
        (["match", "grid", "chalenge-1", "--dry-run"], "did you mean challenge-1?"),
    ],
)
def test_what_was_probably_meant_is_asked(typed: list[str], meant: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert meant in refused(typed, capsys)


@pytest.mark.parametrize(
    ("typed", "said"),
    [
        (
            ["recordings", "export", "--to", "nosuch", "x"],
            "recordings export: --to: unknown value 'nosuch'; known: par",
        ),
        (["recordings", "expor"], "recordings: unknown command 'expor'; did you mean export? known: list, info"),
        (["recordings"], "recordings: name one of: list, info, verify"),
        (["recordings", "export"], "recordings export: missing: FILE|DIR, --to, -o/--out"),
        (["recordings", "export", "--test-share", "x"], "--test-share: 'x' is no share; write 0.2 for a fifth"),
        (["study", "export", "--test-share", "x"], "--test-share: 'x' is no share; write 0.2 for a fifth"),
        (["recordings", "list", "--sort", "date"], "recordings list: unknown option --sort"),
        (["match", "--epsodes", "3"], "match: unknown option --epsodes; did you mean --episodes?"),
        (["match", "--seed"], "match: --seed: a value is missing"),
        (["match", "--challenge", "3"], "match: --challenge: unknown value 3; known: 1, 2"),
        (["study", "simulate", "s.yaml", "--kills", "abc"], "study simulate: --kills: 'abc' is not a whole number"),
        (["play", "--lease", "abc"], "play: --lease: 'abc' is not a number"),
        (["play", "--max-rooms", "abc"], "--max-rooms: a whole number from 1 to 1,000,000 is possible, not abc"),
        (["cluster", "config", "--node", "a=h:1", "--max-connections", "0"], "from 1 to 1,000,000 is possible, not 0"),
        (["doctor", "please"], "doctor: unexpected: please"),
        (["study", "new", "mine.yaml"], "unexpected: mine.yaml (a file or folder to write is named by -o mine.yaml)"),
        (["--nosuch"], "movingout: unknown option --nosuch"),
    ],
)
def test_wrong_use_is_answered_in_two_lines(typed: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    fault, hint = refused(typed, capsys).splitlines()
    assert said in fault
    assert hint.startswith("For help: movingout") and hint.endswith(" --help")


def refused(typed: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    try:
        code: object = main(typed)
    except SystemExit as end:
        code = end.code
    assert code == 2
    return capsys.readouterr().err


def test_a_grid_that_does_not_exist_is_answered_with_those_that_are_shipped(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["match", "grid", "nosuch"]) == 2
    assert "challenge-1" in capsys.readouterr().err


@pytest.mark.parametrize("shell", ["bash", "zsh", "tcsh"])
def test_completion_is_a_script_that_knows_commands_and_options(
    shell: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert main(["completion", shell]) == 0
    script = capsys.readouterr().out
    for word in ("recordings", "randomize", "--challenge"):
        assert word in script
    if program := shutil.which(shell):
        path = tmp_path / "completion"
        path.write_text(script)
        assert subprocess.run([program, "-n", str(path)], capture_output=True).returncode == 0


def test_readme_and_help_name_what_there_is() -> None:
    [shells] = [action.choices for action in PARSERS["movingout completion"]._actions if action.dest == "shell"]
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert shells and all(f"`{shell}`" in readme or f"completion {shell}`" in readme for shell in shells)
    assert "tutorial" in (PARSERS["movingout maps list"].description or "")
    [split] = [action.help for action in PARSERS["movingout maps randomize"]._actions if action.dest == "split"]
    assert all(name in (split or "") for name in SPLITS)


def test_help_imports_no_command() -> None:
    """What makes `movingout --help` fast."""
    code = "import sys; from movingout.server.cli import main\ntry: main(['--help'])\nexcept SystemExit: pass\n"
    code += (
        "print([name for name in sys.modules if name.split('.')[0] in ('numpy', 'fastapi', 'rich', 'shtab', 'torch')])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=os.environ, check=True)
    assert done.stdout.splitlines()[-1] == "[]"
    assert importlib.util.find_spec("shtab")
