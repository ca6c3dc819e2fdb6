"""A picture of a finished round: for its players, never for others, never in a study, and not without end."""

import io
from functools import partial
from pathlib import Path

import pytest
from PIL import Image

from movingout.server.connection.admission import PICTURES_PER_MINUTE
from tests.server.live import ADMIN, Live, serve


def played(live: Live) -> tuple[str, str, str]:
    """Room, recording and seat token after a round of a second."""
    room = live.open_room("here", "idle", limit_ticks=10)
    person = live.person(room["room"], tokens=room["tokens"][:1])
    person.say(type="ready", seat=0)
    return room["room"], person.wait_for("result")["recording"], person.tokens[0]


@pytest.mark.parametrize(("kind", "side"), [("png", 720), ("gif", 320)])
def test_a_player_gets_the_round_as_a_picture_or_an_animation(live: Live, kind: str, side: int) -> None:
    room, recording, token = played(live)
    status, content = live.call(f"/api/rooms/{room}/rounds/{recording}.{kind}", token=token)
    assert status == 200
    picture = Image.open(io.BytesIO(content))
    assert (picture.format, picture.width) == (kind.upper(), side)
    assert len(content) < 1_000_000
    (live.host.settings.recordings / f"{recording}.mcap").unlink()  # a picture in memory goes with its recording
    assert live.call(f"/api/rooms/{room}/rounds/{recording}.{kind}", token=token)[0] == 404


@pytest.mark.slow
def test_others_get_none_and_no_other_round(live: Live) -> None:
    room, recording, token = played(live)
    other_room, other_recording, other_token = played(live)
    asked = f"/api/rooms/{room}/rounds/{recording}"
    assert live.call(f"{asked}.png")[1]["error"]["code"] == "wrong_token"
    assert live.call(f"{asked}.png", token=other_token)[1]["error"]["code"] == "wrong_token"
    for path in (f"/api/rooms/{room}/rounds/{other_recording}.png", f"{asked}.exe"):
        status, answer = live.call(path, token=token)
        assert (status, answer["error"]["code"]) == (404, "no_recording")
    assert live.call(f"/api/rooms/nowhere/rounds/{recording}.png", token=token)[1]["error"]["code"] == "no_room"
    assert other_room != room


@pytest.mark.slow
def test_pictures_are_drawn_once_and_so_many_a_minute(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with serve(tmp_path) as live:
        admission = live.host.admission
        monkeypatch.setattr(admission, "_clock", partial(float, admission._clock()))  # the minute never ends
        rounds = [played(live) for _ in range(PICTURES_PER_MINUTE // 2 + 1)]
        paths = [(f"/api/rooms/{room}/rounds/{name}", token) for room, name, token in rounds]
        answers = [live.call(f"{path}.{kind}", token=token)[0] for path, token in paths for kind in ("png", "gif")]
        assert answers[:PICTURES_PER_MINUTE] == [200] * PICTURES_PER_MINUTE
        status, answer = live.call(f"{paths[-1][0]}.gif", token=paths[-1][1])
        assert (status, answer["error"]["code"]) == (429, "too_many_pictures")
        assert live.call(f"{paths[0][0]}.png", token=paths[0][1])[0] == 200  # drawn already
        live.hang_up()


def test_the_administrator_is_no_player(live: Live) -> None:
    room, recording, _ = played(live)
    assert live.call(f"/api/rooms/{room}/rounds/{recording}.png", token=ADMIN)[0] == 401
