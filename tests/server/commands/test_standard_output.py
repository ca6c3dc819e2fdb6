"""Whatever standard output is, a command ends in a sentence or in nothing: a reader that is gone, a full disk, none."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import movingout

COMMAND = [sys.executable, "-m", "movingout.server.cli"]
FULL = Path("/dev/full")


def test_the_package_itself_is_the_command() -> None:
    """`python -m movingout`, where the folder of scripts is not in PATH; there was no such module."""
    done = subprocess.run([sys.executable, "-m", "movingout", "--version"], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, f"movingout {movingout.__version__}\n", "")
    done = subprocess.run([sys.executable, "-m", "movingout", "no"], capture_output=True, text=True, check=False)
    assert done.returncode == 2 and done.stderr.startswith("movingout: unknown command 'no'")


def test_a_reader_that_goes_away_gets_no_traceback() -> None:
    """`movingout … | head`: a reader that has seen enough is no error to tell anybody about."""
    reading, writing = os.pipe()
    os.close(reading)
    done = subprocess.run([*COMMAND, "demos", "people"], stdout=writing, stderr=subprocess.PIPE, text=True, check=False)
    os.close(writing)
    assert (done.returncode, done.stderr) == (1, "")


@pytest.mark.skipif(not FULL.exists(), reason="needs /dev/full")
@pytest.mark.parametrize(
    "words",
    [["demos", "people"], ["--version"], ["recordings", "list", "--json"], ["--help"], ["train", "--help"]],
)
def test_a_full_disk_is_told_in_a_sentence(words: list[str], tmp_path: Path) -> None:
    """It was a traceback, with the exit code of a check that failed."""
    with FULL.open("w") as full:
        done = subprocess.run(
            [*COMMAND, *words], stdout=full, stderr=subprocess.PIPE, text=True, check=False, cwd=tmp_path
        )
    sentence = "movingout: cannot write to standard output: No space left on device\n"
    assert (done.returncode, done.stderr) == (2, sentence)


def test_what_is_wrong_is_told_though_nobody_reads_the_output() -> None:
    """The reader that went away was all that was told."""
    reading, writing = os.pipe()
    os.close(reading)
    fails = (
        "from movingout.server import cli\nfrom movingout.maps.errors import MovingOutError\n"
        "def perform(arguments):\n    print('begun')\n    raise MovingOutError('the real problem')\n"
        "cli._perform = perform\nraise SystemExit(cli._run(['maps', 'list']))"
    )
    buffered = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
    command = [sys.executable, "-c", fails]
    done = subprocess.run(command, stdout=writing, stderr=subprocess.PIPE, text=True, check=False, env=buffered)
    os.close(writing)
    assert (done.returncode, done.stderr.splitlines()[0]) == (2, "movingout: the real problem")


def test_a_terminal_that_says_it_has_no_columns_gets_the_whole_table() -> None:
    """It printed nothing, and ended well."""
    width = {**os.environ, "COLUMNS": "0"}
    done = subprocess.run([*COMMAND, "maps", "list"], capture_output=True, text=True, check=True, env=width)
    assert "HandOff" in done.stdout


def test_without_standard_output_a_command_does_its_work() -> None:
    closed = 'exec "$0" "$@" >&-'
    done = subprocess.run(
        ["sh", "-c", closed, *COMMAND, "maps", "list"], stderr=subprocess.PIPE, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")


def test_what_the_encoding_of_a_c_locale_lacks_is_escaped() -> None:
    """A table ended in a traceback, after all matches had been played."""
    plain = {name: value for name, value in os.environ.items() if name != "PYTHONIOENCODING"}
    ascii_only = plain | {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    done = subprocess.run([*COMMAND, "maps", "list"], capture_output=True, env=ascii_only, check=False)
    assert (done.returncode, done.stderr) == (0, b"")


def test_a_name_that_is_not_utf8_is_escaped(tmp_path: Path) -> None:
    try:
        (tmp_path / os.fsdecode(b"caf\xe9.json")).write_text("{}")
    except OSError:
        pytest.skip("file names are UTF-8 here")
    strict = os.environ | {"PYTHONIOENCODING": "utf-8:strict"}
    done = subprocess.run([*COMMAND, "maps", "check", str(tmp_path)], capture_output=True, env=strict, check=False)
    assert done.returncode == 1 and b"Traceback" not in done.stderr
    assert rb"caf\udce9.json" in done.stdout
