"""Where the Chromium of these tests comes from."""

from pathlib import Path

import pytest

from tests.browser.install import VARIABLE, NoBrowser, find_chromium


def test_a_named_browser_goes_before_all_others(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    mine = tmp_path / "chromium"
    mine.touch()
    monkeypatch.setenv(VARIABLE, str(mine))
    assert find_chromium() == mine


def test_a_named_browser_that_is_not_there_is_said_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, "/nowhere/chromium")
    with pytest.raises(NoBrowser, match="names /nowhere/chromium, which is not a file"):
        find_chromium()
