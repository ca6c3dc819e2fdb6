"""What the README tells users to type works, in the order in which it stands there, and its links lead somewhere."""

import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)
BIN = ".venv/bin/"
PREPARATION = [
    "match",
    "--red",
    "idle",
    "--blue",
    "idle",
    "--map",
    "Simple",
    "--ticks",
    "20",
    "--record",
    "data/recordings",
]


def blocks(language: str) -> list[str]:
    return [text for found, text in BLOCK.findall(README) if found == language]


def commands() -> list[list[str]]:
    lines = [line for block in blocks("sh") for line in block.splitlines()]
    return [shlex.split(line, comments=True) for line in lines if line]


def run(command: list[str], folder: Path, code: int = 0) -> str:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=200, check=False)
    assert done.returncode == code, f"{shlex.join(command)}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def fill_in(study: Path) -> None:
    """The blanks of a template's consent, as a researcher fills them in."""
    text = study.read_text(encoding="utf-8").replace('protocol: ""', 'protocol: "2026-17"')
    study.write_text(re.sub(r"\[(name|review)[^\]]+\]", "Dr Ada Lovelace, Room 5", text), encoding="utf-8")


@pytest.mark.slow
def test_every_movingout_command_of_the_readme_works(tmp_path: Path) -> None:
    movingout = str(Path(sys.executable).parent / "movingout")
    run([movingout, *PREPARATION], tmp_path)
    known = [command for command in commands() if command[0] == f"{BIN}movingout"]
    assert len(known) >= 8
    for command in known:
        if command[1:3] == ["study", "check"]:
            missing = [line for line in run([movingout, *command[1:]], tmp_path, 1).splitlines() if "missing: " in line]
            assert len(missing) == 3 and all("missing: the consent has" in line for line in missing)
            fill_in(tmp_path / command[3])
        run([movingout, *command[1:]], tmp_path)
    assert (tmp_path / "report.html").stat().st_size > 10_000


def test_every_other_command_of_the_readme_is_make_with_a_known_target() -> None:
    others = [command for command in commands() if command[0] != f"{BIN}movingout"]
    assert {command[0] for command in others} == {"make"}
    if shutil.which("make") is None:
        pytest.skip("make is not installed")
    for command in others:
        run(["make", "--dry-run", *command[1:]], ROOT)


def test_the_python_example_of_the_readme_runs() -> None:
    for block in blocks("python"):
        run([sys.executable, "-W", "error", "-c", block], ROOT)


@pytest.mark.parametrize(
    "page", ["README.md", "CONTRIBUTING.md", *(f"docs/{path.name}" for path in (ROOT / "docs").glob("*.md"))]
)
def test_every_link_leads_to_a_file(page: str) -> None:
    text = (ROOT / page).read_text(encoding="utf-8")
    links = [link.split("#")[0] for link in re.findall(r"\]\(([^)\s]+)\)", text) if "://" not in link]
    missing = [link for link in links if link and not ((ROOT / page).parent / link).exists()]
    assert missing == []


def test_the_readme_is_short() -> None:
    assert len(README.splitlines()) <= 150
