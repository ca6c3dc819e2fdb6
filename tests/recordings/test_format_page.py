"""docs/recording-format.md: its program runs, its tables are complete."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
from mcap.reader import make_reader

from movingout.recordings import finalise
from tests.recordings.support import record
from tests.support import ROOT

PAGE = (ROOT / "docs" / "recording-format.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return finalise(record(tmp_path_factory.mktemp("page"), ticks=9)[0])


def test_the_ten_line_reader_reads_a_recording(finished: Path, tmp_path: Path) -> None:
    (program,) = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    assert len([line for line in program.splitlines() if line.strip()]) <= 10
    (tmp_path / "read.py").write_text(program, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-I", "read.py", str(finished)], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    first, second = done.stdout.splitlines()
    assert first == "HandOff P-3f2a scripted time"
    assert second.startswith("9 ")
    assert second.endswith("[False, False, False, False]")


def test_the_page_names_every_topic_and_metadata_record(finished: Path) -> None:
    with finished.open("rb") as stream:
        reader = make_reader(stream)
        summary = reader.get_summary()
        names = {record.name for record in reader.iter_metadata()}
    assert summary is not None
    for name in {channel.topic for channel in summary.channels.values()} | names:
        assert f"`{name}`" in PAGE, f"{name} is missing on the page"
