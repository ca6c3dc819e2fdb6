"""Maps over HTTP: the operator's own, and what the editor asks for maps that somebody draws."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from movingout.maps import MapSpec, load_map, map_from_json, map_to_json
from movingout.maps.generated.proved import proved_maps
from movingout.recordings import read_episode
from movingout.recordings.verification import verify
from movingout.server.api import map_routes
from movingout.server.cli import main
from movingout.server.own_maps.folder import LOOK_S, MapFolder
from tests.server.live import Live, limits, serve

SEATS = [{"kind": "here"}, {"kind": "agent", "agent": "idle"}]


def document(name: str = "Garage", **changes: object) -> dict[str, Any]:
    return map_to_json(load_map("Simple")) | {"name": name, "title": "The Garage", "number": 0, **changes}


def put(folder: Path, file: str, content: object) -> None:
    folder.mkdir(exist_ok=True)
    (folder / file).write_text(json.dumps(content), encoding="utf-8")


@pytest.fixture(scope="module")
def with_garage(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Live]:
    """A server with a folder of one map."""
    folder = tmp_path_factory.mktemp("garage")
    put(folder / "mine", "garage.json", document())
    with serve(folder / "data", maps=folder / "mine") as live:
        yield live


def asked(live: Live, **room: object) -> tuple[int, Any]:
    return live.call("/api/rooms", {"maps": [], "seats": SEATS, "limit_ticks": 10, **room})


def played(live: Live, room: dict[str, Any]) -> str:
    """Play a room's first round to its end; the id of its recording, which is finished."""
    person = live.person(room["room"], tokens=[room["tokens"][0]])
    person.wait_for("round")
    person.say(type="ready", seat=0, ready=True)
    episode = str(person.play_out()["recording"])
    assert live.call(f"/api/recordings/{episode}")[0] == 200
    return episode


@pytest.mark.slow
def test_maps_of_the_folder_are_offered_played_recorded_and_played_against(tmp_path: Path) -> None:
    put(tmp_path / "mine", "garage.json", document())
    put(tmp_path / "mine", "broken.json", {"format": 1})
    with serve(tmp_path / "data", maps=tmp_path / "mine") as live:
        _, offered = live.call("/api/maps")
        assert [each["name"] for each in offered["own"]] == ["Garage"]
        assert offered["own_left_out"] == 1
        assert "broken" not in json.dumps(offered), "what is in a file that is no map is not for visitors"
        status, room = asked(live, maps=["Garage"])
        assert status == 200, room
        episode = played(live, room)
        path = live.host.settings.recordings / f"{episode}.mcap"
        assert read_episode(path).header.map == map_from_json(document())
        assert verify(path).identical
        (tmp_path / "mine" / "garage.json").unlink()  # the recording has the map in itself
        ghost = {"kind": "ghost", "recording": episode}
        status, again = live.call("/api/rooms", {"maps": [], "seats": [ghost, {"kind": "here"}], "limit_ticks": 10})
        assert status == 200, again
        assert live.call(f"/api/rooms/{again['room']}")[1]["map"] == "Garage"


@pytest.mark.slow
def test_generated_maps_are_offered_played_and_recorded_whole(tmp_path: Path) -> None:
    with serve(tmp_path / "data") as live:
        _, offered = live.call("/api/maps")
        assert offered["surprise"] == list(proved_maps("validation")), "recordings are trained on"
        name = f"{offered['surprise'][0]}:mirror"
        assert live.call(f"/api/maps/{name}") == (200, map_to_json(load_map(name)))
        status, room = asked(live, maps=[name])
        assert status == 200, room
        path = live.host.settings.recordings / f"{played(live, room)}.mcap"
        assert read_episode(path).header.map == load_map(name)
        assert verify(path).identical
        status, refused = asked(live, maps=["generated:awarenes:1"])
        assert status == 422
        assert "did you mean awareness?" in json.dumps(refused)


def test_a_map_that_no_list_has_is_there_by_its_name(tmp_path: Path) -> None:
    put(tmp_path / "mine", "garage.json", document())
    with serve(tmp_path / "data", maps=tmp_path / "mine") as live:
        assert live.call("/api/maps/HandOff:mirror") == (200, map_to_json(load_map("HandOff:mirror")))
        assert live.call("/api/maps/Garage:rot90")[1]["name"] == "Garage:rot90"
        status, refused = live.call("/api/maps/HandOf")
        assert (status, refused["error"]["code"], refused["error"]["values"]) == (422, "unknown_map", {"map": "HandOf"})


@pytest.mark.parametrize(
    ("path", "told"),
    [
        ("my%2Fmap", "my/map"),
        ("a/b/", "a/b/"),
        ("x" * 60, "x" * 60),
        ("x" * 3000, "x" * 59 + "…"),
        ("generated:" + "x" * 3000, "generated:" + "x" * 49 + "…"),
    ],
)
def test_the_map_that_is_not_there_is_named_also_with_a_slash_and_shortened(live: Live, path: str, told: str) -> None:
    status, refused = live.call(f"/api/maps/{path}")
    assert (status, refused["error"]["code"], refused["error"]["values"]) == (422, "unknown_map", {"map": told})


@pytest.mark.slow
def test_mirrored_turned_and_randomised_maps_of_the_folder_are_played(tmp_path: Path) -> None:
    put(tmp_path / "mine", "garage.json", document())
    with serve(tmp_path / "data", maps=tmp_path / "mine") as live:
        status, room = asked(live, maps=["Garage:mirror", "HandOff", "Garage"], challenge2_seed=4)
        assert status == 200, room
        person = live.person(room["room"], tokens=[room["tokens"][0]])
        the_map = person.wait_for("round")["map"]
        assert (the_map["name"], the_map["variant"]) == ("Garage:mirror", "challenge2-train-4")


@pytest.mark.slow
def test_a_file_that_is_added_while_serving_is_offered(tmp_path: Path) -> None:
    put(tmp_path / "mine", "garage.json", document())
    with serve(tmp_path / "data", maps=tmp_path / "mine") as live:
        put(tmp_path / "mine", "shed.json", document("Shed"))
        live.host.own_maps._looked -= LOOK_S
        assert [each["name"] for each in live.call("/api/maps")[1]["own"]] == ["Garage", "Shed"]
        assert asked(live, maps=["Shed"])[0] == 200


def test_maps_are_written_out_once_for_everybody_and_again_when_they_change(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With 200 maps it takes 30 ms on the loop of the ticks, and one address may ask 60 times a second."""
    put(tmp_path / "mine", "garage.json", document())
    written: list[str] = []

    def counted(spec: MapSpec) -> dict[str, Any]:
        written.append(spec.name)
        return map_to_json(spec)

    monkeypatch.setattr(map_routes, "map_to_json", counted)
    own = MapFolder(tmp_path / "mine", clock=lambda: 0.0)
    own.read()
    offered = map_routes.OfferedMaps(own)
    first = offered.document()
    assert offered.document() == first and written.count("Garage") == 1
    own.read()  # nothing has changed
    assert offered.document() == first and written.count("Garage") == 1
    put(tmp_path / "mine", "broken.json", {"format": 1})
    put(tmp_path / "mine", "shed.json", document("Shed"))
    own.read()
    assert [each["name"] for each in json.loads(offered.document())["own"]] == ["Garage", "Shed"]
    assert json.loads(offered.document())["own_left_out"] == 1


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("Garag", "unknown map 'Garag'; did you mean Garage? known: HandOff, "),
        ("Garage:flip", "unknown symmetry 'flip' of Garage; known: mirror, rot90, rot180, rot270"),
    ],
)
def test_an_unknown_map_is_answered_with_those_of_the_folder_too(with_garage: Live, name: str, sentence: str) -> None:
    status, refused = asked(with_garage, maps=[name])
    assert (status, refused["error"]["code"]) == (422, "unknown_map")
    assert sentence in refused["error"]["message"]


def test_a_room_on_an_own_map_comes_back_after_a_restart_without_its_file(tmp_path: Path) -> None:
    put(tmp_path / "mine", "garage.json", document())
    with serve(tmp_path / "data", maps=tmp_path / "mine") as live:
        _, room = asked(live, maps=["Garage"])
    with serve(tmp_path / "data") as live:
        status, view = live.call(f"/api/rooms/{room['room']}")
        assert (status, view["map"]) == (200, "Garage")


@pytest.mark.parametrize("name", ["../mine/garage.json", "garage.json", "mine/garage", "/etc/passwd", "garage", ""])
def test_only_names_reach_maps_never_paths(with_garage: Live, name: str) -> None:
    status, answer = asked(with_garage, maps=[name])
    assert (status, answer["error"]["code"]) == (422, "unknown_map")


def test_a_folder_that_is_not_there_is_told_before_the_server_starts(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["play", "--data", str(tmp_path / "d"), "--port", "0", "--maps", str(tmp_path / "absent")]) == 2
    assert "cannot read the folder of maps" in capsys.readouterr().err


# ---- the editor -----------------------------------------------------------------------------------------------


def checked(live: Live, drawn: object) -> Any:
    status, answer = live.call("/api/editor/check", {"map": drawn})
    assert status == 200, answer
    return answer


def test_a_sound_map_has_no_faults_and_comes_back_in_our_format(live: Live) -> None:
    assert checked(live, document()) == {"map": document(), "faults": [], "hints": []}
    official = {
        "robot_1_pos": [-0.6, -1], "robot_1_angle": 0, "robot_2_pos": [0.6, -1], "robot_2_angle": 0,
        "walls": [[None]], "target_areas": [[[-1.2, 1.2], [-0.6, 0.6]]],
        "items": {"0": {"pos": [0, 0], "angle": 0, "shape": "circle", "size": "small", "mass": 1, "shape_scale": 0.06}},
    }  # fmt: skip
    answer = checked(live, official)
    assert answer["faults"] == [] and answer["map"]["robots"]["red"]["x"] == 0.6


def test_faults_have_the_checkers_sentences_and_codes_with_values(live: Live) -> None:
    wall = {"x0": -1.2, "y0": -1.2, "x1": 1.2, "y1": -0.9}
    robots = document()["robots"] | {"blue": {"x": 0.0, "y": -1.0, "angle": 0.0}}
    faults = checked(live, document(walls=[wall], robots=robots))["faults"]
    assert faults[0] == {
        "path": "robots.blue",
        "message": "stands in walls[0]; walls are 0.01 thicker than drawn",
        "code": "in_wall",
        "values": {"other": "walls[0]"},
    }
    answer = checked(live, document("HandOff:mirror"))
    assert [(one["path"], one["code"]) for one in answer["faults"]] == [("name", "name_taken")]
    assert answer["hints"] == []


def test_hints_keep_no_map_from_being_played(live: Live) -> None:
    drawn = document(number=4, goals=[{"x0": -1.2, "y0": 1.2, "x1": 1.2, "y1": -1.2}])
    answer = checked(live, drawn)
    assert answer["faults"] == []
    assert [(hint["path"], hint["code"], hint["values"]) for hint in answer["hints"][:2]] == [
        ("number", "paper_number", {"number": 4}),
        ("items[0]", "delivered", {}),
    ]
    status, _ = live.call("/api/rooms", {"maps": [], "seats": SEATS, "map": drawn})
    assert status == 200


@pytest.mark.parametrize(
    "rubbish",
    [None, 3, "map", [], {}, {"format": 1}, document(items=[]), document(walls=[{"x0": 1}]), document(goals="all"),
     {"robot_1_pos": 3}, document(title="x" * 501), document(items=[{"x": 10**400}]), [[[[[[]]]]]]],
)  # fmt: skip
def test_rubbish_is_answered_with_sentences(live: Live, rubbish: object) -> None:
    answer = checked(live, rubbish)
    assert answer["map"] is None
    assert answer["faults"] and all(fault["message"] and len(fault["message"]) < 600 for fault in answer["faults"])
    for path in ("/api/editor/solve", "/api/rooms"):
        body = {"map": rubbish} if path.endswith("solve") else {"maps": [], "seats": SEATS, "map": rubbish}
        status, refused = live.call(path, body)
        if rubbish is None and path == "/api/rooms":
            assert (status, refused["error"]["code"]) == (422, "maps")  # no map at all
        else:
            assert status == 422 and refused["error"]["code"] in ("map_faulty", "bad_request")


def test_more_than_a_map_can_be_is_not_taken(live: Live) -> None:
    status, answer = live.call("/api/editor/check", {"map": document(description="x" * 20_000)})
    assert (status, answer["error"]["code"]) == (413, "too_large")
    status, answer = live.call("/api/editor/check", {"map": {}, "path": "/etc/passwd"})
    assert (status, answer["error"]["code"]) == (422, "bad_request")


def test_a_drawn_map_is_played_recorded_and_verified(live: Live) -> None:
    status, room = asked(live, map=document("Drawn"))
    assert status == 200, room
    path = live.host.settings.recordings / f"{played(live, room)}.mcap"
    assert read_episode(path).header.map == map_from_json(document("Drawn"))
    assert verify(path).identical


@pytest.mark.parametrize(
    ("drawn", "more", "code"),
    [
        (document("HandOff"), {}, "map_name"),
        (document(items=document()["items"][:1] * 2), {}, "map_faulty"),
        (document(), {"maps": ["Simple"]}, "maps"),
    ],
)
def test_a_drawn_map_that_cannot_be_played_opens_no_room(
    live: Live, drawn: dict[str, Any], more: dict[str, Any], code: str
) -> None:
    rooms = len(live.rooms)
    status, answer = asked(live, map=drawn, **more)
    assert (status, answer["error"]["code"]) == (422, code)
    assert len(live.rooms) == rooms


def test_a_scripted_pair_solves_a_map_and_shows_how(live: Live) -> None:
    status, answer = live.call("/api/editor/solve", {"map": document()})
    assert status == 200, answer
    assert (answer["solved"], answer["delivered"], answer["items"]) == (True, 3, 3)
    assert len(answer["frames"]) == answer["ticks"] + 1 < answer["limit_ticks"]
    assert answer["frames"][0]["poses"][2] == pytest.approx(
        [document()["items"][0][key] for key in ("x", "y", "angle")], abs=1e-4
    )
    assert answer["frames"][-1]["delivered"] == [True, True, True]


@pytest.mark.slow
def test_one_address_can_only_ask_so_often(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("movingout.server.connection.admission.MAP_WORK_S", 1e6)  # checks count, not their time
    with serve(tmp_path, limits=limits(map_checks_per_minute=2, map_solves_per_minute=1)) as live:
        answers = [live.call("/api/editor/check", {"map": document()})[0] for _ in range(3)]
        assert answers == [200, 200, 429]
        answers = [live.call("/api/editor/solve", {"map": {}})[0] for _ in range(2)]
        assert answers == [422, 429]


def test_pages_of_other_origins_may_not_ask(live: Live) -> None:
    status, answer = live.call("/api/editor/check", {"map": {}}, Origin="http://elsewhere.example")
    assert (status, answer["error"]["code"]) == (403, "origin")


def test_a_server_that_runs_a_study_has_no_editor(tmp_path: Path) -> None:
    with serve(tmp_path, lobby=False) as live:
        assert live.call("/api/editor/check", {"map": document()})[0] in (404, 405)
        assert live.call("/editor")[0] == 404
