"""Whoever asks for what an extra brings is told which command installs it."""

import sys
import tomllib

import pytest

from movingout.maps.extras import MissingExtraError, needs_extra
from movingout.server.cli import main
from tests.support import ROOT

LOADED_ON_DEMAND = ("movingout.recordings.viewer", "movingout.server.study_bots")
EXTRAS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]


def test_a_missing_library_is_named_by_its_extra() -> None:
    with (
        pytest.raises(MissingExtraError, match=r"the film needs the extra `video`; .* pip install 'moving-out-live\[v"),
        needs_extra("video", "the film"),
    ):
        import no_such_library  # type: ignore[import-not-found]  # noqa: F401


def test_a_module_of_our_own_that_is_missing_stays_a_fault() -> None:
    with pytest.raises(ModuleNotFoundError, match=r"movingout\.no_such_module"), needs_extra("video", "the film"):
        import movingout.no_such_module  # type: ignore[import-not-found]  # noqa: F401


@pytest.mark.parametrize(
    ("extra", "library", "words"),
    [
        ("view", "viser", ["recordings", "view", "FILE", "--html", "page.html"]),
        ("view", "viser", ["recordings", "view", "FILE"]),
        ("simulate", "httpx", ["study", "simulate", "study.yaml"]),
    ],
)
def test_a_command_says_which_extra_it_needs(
    extra: str, library: str, words: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in [name for name in sys.modules if name.startswith(LOADED_ON_DEMAND)]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, library, None)
    recording = next((ROOT / "tests/fixtures/recordings").glob("*.mcap"))
    assert main([str(recording) if word == "FILE" else word for word in words]) == 2
    assert f"pip install 'moving-out-live[{extra}]'" in capsys.readouterr().err
    assert any(requirement.startswith(library) for requirement in EXTRAS[extra])
