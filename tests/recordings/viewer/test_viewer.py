"""The viewer as a server and as a page to hand on; no browser."""

import re
import socket
import urllib.request
from pathlib import Path

import pytest

from movingout.recordings import RecordingError
from movingout.recordings.viewer.recording_cache import RecordingCache
from movingout.recordings.viewer.viewer import Viewer, open_server
from movingout.server.cli import main
from tests.recordings.viewer.support import recorded


def test_the_viewer_serves_its_page_on_loopback_and_says_nothing_by_itself(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    with Viewer(RecordingCache([recorded(tmp_path)])) as viewer:
        assert viewer.url.startswith("http://127.0.0.1:")
        with urllib.request.urlopen(viewer.url, timeout=10) as answer:
            assert b"<html" in answer.read()
    assert capfd.readouterr().out == ""


def test_a_visitor_cannot_open_a_tunnel_to_the_world(tmp_path: Path) -> None:
    with Viewer(RecordingCache([recorded(tmp_path)])) as viewer:
        assert viewer.server.request_share_url() is None


def test_a_port_in_use_gets_a_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        assert main(["recordings", "view", str(recorded(tmp_path)), "--port", str(port)]) == 2
    heard = capsys.readouterr().err
    assert f"cannot listen on 127.0.0.1 port {port}" in heard and "--port" in heard


@pytest.mark.parametrize(("host", "port"), [("203.0.113.7", 0), ("127.0.0.1", 70_000)])
def test_an_address_that_cannot_be_had_gets_a_sentence(host: str, port: int) -> None:
    with pytest.raises(RecordingError, match=f"cannot listen on {host} port {port}"):
        open_server(host, port)


def test_a_file_that_is_missing_or_broken_is_told_before_a_page_opens(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    broken = tmp_path / "broken.mcap"
    broken.write_bytes(b"")
    assert main(["recordings", "view", str(broken), "--port", "0"]) == 2
    assert "broken.mcap is empty" in capsys.readouterr().err
    assert main(["recordings", "view", "nobody", "--data", str(tmp_path)]) == 2
    assert "there is no recording 'nobody'" in capsys.readouterr().err


def test_a_page_is_one_file_that_asks_the_network_for_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "page.html"
    assert main(["recordings", "view", str(recorded(tmp_path)), "--html", str(out)]) == 0
    assert capsys.readouterr().out.startswith(f"wrote {out}")
    text = out.read_text(encoding="utf-8")
    head = re.sub(r"<(script|style)\b[^>]*>.*?</\1>", "", text, flags=re.DOTALL)
    assert not re.findall(r"(?:src|href)=[\"'](?!data:)[^\"']+", head)
    assert "__VISER_EMBED_DATA__" in text
    assert [path for path in tmp_path.iterdir() if out.name in path.name] == [out]


def test_a_page_holds_two_episodes_at_most(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    paths = [str(recorded(tmp_path, name, 3)) for name in "abc"]
    assert main(["recordings", "view", *paths, "--html", str(tmp_path / "page.html")]) == 2
    assert "one or two episodes, not 3" in capsys.readouterr().err


def test_a_page_that_cannot_be_written_leaves_nothing_behind(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "nowhere" / "page.html"
    assert main(["recordings", "view", str(recorded(tmp_path, ticks=3)), "--html", str(out)]) == 2
    assert "cannot write" in capsys.readouterr().err
    assert not out.parent.exists()


def test_a_page_never_takes_the_place_of_a_recording(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = recorded(tmp_path, ticks=3)
    before = path.read_bytes()
    assert main(["recordings", "view", str(path), "--html", str(path)]) == 2
    assert "should end in .html" in capsys.readouterr().err
    assert path.read_bytes() == before


def test_recordings_of_one_name_in_two_folders_stay_apart(tmp_path: Path) -> None:
    paths = []
    for folder in ("monday", "tuesday"):
        (tmp_path / folder).mkdir()
        paths.append(recorded(tmp_path / folder, ticks=3))
    cache = RecordingCache(paths)
    assert cache.names == tuple(map(str, paths))
    assert cache.shown_first == cache.names
