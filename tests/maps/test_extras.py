"""Whoever asks for what an extra brings is told which command installs it."""

import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from movingout.maps import extras
from movingout.maps.extras import MissingExtraError, install_command, needs_extra
from movingout.server.cli import main
from tests.support import ROOT

LOADED_ON_DEMAND = ("movingout.recordings.viewer", "movingout.server.study_bots")
EXTRAS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]


def test_a_missing_library_is_named_by_its_extra() -> None:
    with (
        pytest.raises(MissingExtraError, match=r"the film needs the extra `video`; .* -m pip install .*\[video\]'?$"),
        needs_extra("video", "the film"),
    ):
        import no_such_library  # type: ignore[import-not-found]  # noqa: F401


def test_from_a_checkout_the_command_installs_it_in_the_pinned_versions_wherever_it_is_called() -> None:
    """It named a package that nobody has released; whoever takes that name would have been installed."""
    pins = str(ROOT / "constraints.txt")
    parts = [sys.executable, "-m", "pip", "install", "-c", pins, "-e", f"{ROOT}[video]"]
    assert shlex.split(install_command("video")) == parts


def test_where_the_package_is_installed_pip_adds_to_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(extras, "_ROOT", tmp_path)
    monkeypatch.setattr(sys, "executable", "/my env/bin/python")
    assert install_command("tls") == "'/my env/bin/python' -m pip install 'moving-out-live[tls]'"


def test_pages_name_one_form() -> None:
    pages = [*(ROOT / "docs").glob("*.md"), ROOT / "README.md", ROOT / "examples" / "tutorial.ipynb"]
    assert [page.name for page in pages if "moving-out-live[" in page.read_text(encoding="utf-8")] == []


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
    assert f"install it with: {install_command(extra)}" in capsys.readouterr().err
    assert any(requirement.startswith(library) for requirement in EXTRAS[extra])


@pytest.mark.slow
def test_studies_and_certificates_are_extras_of_a_server(tmp_path: Path) -> None:
    code = (
        "import sys; sys.modules['sqlalchemy'] = sys.modules['cryptography'] = None\n"
        "from movingout.server.cli import main\n"
        f"main(['study', 'new']); main(['play', '--tls', '--port', '0', '--data', {str(tmp_path / 'data')!r}])"
    )
    said = subprocess.run([sys.executable, "-P", "-c", code], capture_output=True, text=True, check=True).stderr
    assert "a study needs the extra `study`; install it with: " + install_command("study") in said
    assert "--tls needs the extra `tls`; install it with: " + install_command("tls") in said
