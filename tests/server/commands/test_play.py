"""What `movingout play` prints at its start."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from movingout.maps import load_map, map_to_json
from movingout.server.cli import main
from movingout.server.commands.play import hints, tell_own_maps
from movingout.server.own_maps.folder import MapFolder
from movingout.server.persistence.data_folder import (
    BadDataFolder,
    refuse_cluster_folder,
    refuse_served_folder,
    refuse_study_folder,
)
from movingout.server.settings import Settings


@pytest.mark.parametrize(
    ("settings", "hint"),
    [
        (Settings(), "Only this machine can connect. For others in the network: movingout play --host 0.0.0.0 --tls"),
        (Settings(host="0.0.0.0"), "On other machines gamepads need https: add --tls."),
        (Settings(host="192.168.1.5"), "On other machines gamepads need https: add --tls."),
        (Settings(tls=True), "The certificate is self-signed: the browser asks once whether to trust it."),
        (Settings(trusted_proxies=("127.0.0.1",)), "These addresses lie behind the proxy; give people the proxy's."),
        (
            Settings(allowed_hosts=("game.example.org",)),
            "Only this machine can connect. Name its reverse proxy, or everybody shares the limits of one address: "
            "movingout play --proxy 127.0.0.1",
        ),
        (
            Settings(host="0.0.0.0", trusted_proxies=("10.0.0.0/8",)),
            "These addresses lie behind the proxy; give people the proxy's.",
        ),
    ],
)
def test_the_hint_says_who_can_connect(settings: Settings, hint: str) -> None:
    assert hints(settings, "movingout play") == [hint, ""]


@pytest.mark.parametrize(
    ("partner", "sentence"),
    [
        ("no_such_module:Policy", "cannot import 'no_such_module': ModuleNotFoundError"),
        ("tests.agents.support:broken_factory", "could not be made: RuntimeError: no weights here (tests/agents"),
        ("tests.agents.support:Untrained", "tests.agents.support:Untrained raised ValueError: no weights"),
        ("tests.agents.support:Flat", "the partner tests.agents.support:Flat cannot play: an action chunk has shape"),
        ("scripted:patience=abc", "style: patience must lie between"),
    ],
)
def test_a_partner_that_cannot_be_made_or_played_is_refused_at_the_start(
    partner: str, sentence: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["play", "--partner", partner, "--port", "0", "--data", str(tmp_path)]) == 2
    assert sentence in capsys.readouterr().err


@pytest.mark.parametrize("more", [[], ["--cluster", "postgresql://nowhere/x", "--node", "a"]], ids=["alone", "node"])
def test_a_data_folder_that_cannot_be_looked_at_is_named_in_a_sentence(
    more: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    """As one below a folder of somebody else, which root could look at."""
    assert main(["play", "--data", "x" * 300, "--port", "0", *more]) == 2
    said = capsys.readouterr().err
    assert f"cannot look at the data folder {'x' * 300} (File name too long)" in said and "Traceback" not in said


@pytest.mark.parametrize("refuse", [refuse_study_folder, refuse_cluster_folder, refuse_served_folder])
def test_each_look_at_a_data_folder_ends_in_a_sentence(refuse: Callable[[Path], None]) -> None:
    with pytest.raises(BadDataFolder, match="cannot look at the data folder"):
        refuse(Path("x" * 300))


@pytest.mark.parametrize("inside", ["recordings", "rooms", "answers"])
def test_a_file_where_a_folder_should_be_is_named_in_a_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], inside: str
) -> None:
    """It ended in a traceback."""
    (tmp_path / inside).write_text("x")
    assert main(["play", "--data", str(tmp_path), "--port", "0", "--processes", "1"]) == 2
    said = capsys.readouterr().err
    assert f"cannot write to {tmp_path / inside} (File exists); move it away" in said and "Traceback" not in said


@pytest.mark.parametrize(
    ("partner", "why"),
    [
        ("bass@any:partner=x", "partner=policy or"),
        ("scripted:speed=3", "no habit 'speed'"),
        ("bass@all:simulator=oracle", "matches without people"),
    ],
)
def test_a_partner_with_options_that_cannot_be_is_refused_at_the_start(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], partner: str, why: str
) -> None:
    assert main(["play", "--data", str(tmp_path / "data"), "--port", "0", "--partner", partner]) == 2
    assert why in capsys.readouterr().err
    assert not (tmp_path / "data").exists()


def test_what_is_wrong_with_own_maps_and_what_probably_is_is_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    den = map_to_json(load_map("HandOff")) | {"name": "Den", "number": 4}
    (tmp_path / "den.json").write_text(json.dumps(den))
    (tmp_path / "none.json").write_text("[]")
    own = MapFolder(tmp_path)
    own.read()
    tell_own_maps(own)
    assert capsys.readouterr().err.splitlines() == [
        "movingout: own map left out: none.json: the map: an object is needed here",
        "movingout: own map Den: number: numbers are those of the paper's maps; write 0 for a map of your own",
    ]


def test_a_folder_without_a_map_is_told_of(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for folder in (tmp_path, None):
        own = MapFolder(folder)
        own.read()
        tell_own_maps(own)
    assert capsys.readouterr().err == f"movingout: there is no map file in {tmp_path} yet\n"
