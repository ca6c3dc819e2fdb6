"""Rooms on maps that cannot be varied, or not now: that is said, and no partner is blamed."""

from collections.abc import Iterator

import pytest

from movingout.maps import MapError, MapSpec, load_map, map_to_json
from movingout.server.own_maps.workers import Busy
from tests.server.live import Live, serve


@pytest.fixture(scope="module")
def live(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Live]:
    with serve(tmp_path_factory.mktemp("variants")) as running:
        yield running


@pytest.mark.parametrize("second", ["link", "partner"])
@pytest.mark.parametrize(
    ("error", "status", "code"), [(MapError("no variant"), 422, "map_variant"), (Busy("many maps"), 503, "map_busy")]
)
def test_what_keeps_a_map_from_being_varied_is_said_after_one_search(
    live: Live, monkeypatch: pytest.MonkeyPatch, error: Exception, status: int, code: str, second: str
) -> None:
    searched: list[int] = []

    async def none(designed: MapSpec, seed: int, split: str, address: str) -> MapSpec:
        searched.append(seed)
        raise error

    monkeypatch.setattr(live.host.map_workers, "variant", none)
    wanted = {"maps": ["Simple"], "seats": [{"kind": "here"}, {"kind": second}], "challenge2_seed": 3}
    found, answer = live.call("/api/rooms", wanted)
    assert (found, answer["error"]["code"], searched) == (status, code, [3])


def test_a_drawn_map_of_a_room_is_a_check_of_its_address(live: Live, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(live.host.admission, "may_check_map", lambda address: False)
    drawn = map_to_json(load_map("Simple")) | {"name": "Garage", "title": "The Garage", "number": 0}
    wanted = {"maps": [], "map": drawn, "seats": [{"kind": "here"}, {"kind": "link"}]}
    assert live.call("/api/rooms", wanted)[0] == 429
