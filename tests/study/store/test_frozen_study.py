"""A study that has begun is run with the same file, models and kind of participants to its end."""

import json
from pathlib import Path

import pytest
from sqlalchemy import insert

from movingout.maps import load_map, map_to_json
from movingout.study.data.versions import agent_code, model_hashes
from movingout.study.errors import StudyError
from movingout.study.store.frozen_study import code_by_time, freeze_study, frozen_study, has_begun
from movingout.study.store.tables import audit, participants, units
from tests.study.support import TEXT, Clock, agree, open_store, study


def test_a_study_that_has_begun_keeps_its_file_and_its_models(place: Path | str) -> None:
    store = open_store(place)
    open_store(place, text=TEXT + "# before anybody came\n").close()
    agree(store, ["P1"])
    with pytest.raises(
        StudyError, match="study agent-survey has begun, and its file or a text beside it has changed since"
    ):
        open_store(place, text=TEXT)
    with pytest.raises(StudyError, match=r"restore it \(`movingout study backup` writes it as it was"):
        open_store(place, text=TEXT)
    with pytest.raises(StudyError, match=r"knows nobody who has taken part: exclude them .*/link-key is copied"):
        open_store(place, text=TEXT)
    freeze_study(store, "agent-survey", TEXT + "# before anybody came\n", {"movingout": "mended"}, {"scripted": ""})
    assert frozen_study(store).code == {"movingout": "mended"}
    assert [row["action"] for row in store.rows(audit)] == ["freeze", "freeze", "arrive", "consent", "code"]


@pytest.mark.parametrize("simulated", [False, True])
def test_a_study_that_nobody_has_consented_to_may_change_and_who_reads_it_begins_anew(
    place: Path | str, simulated: bool
) -> None:
    """Their page may show a text for which another one would be kept as what they agreed to."""
    store = open_store(place)
    store.arrive("P1", "en")
    assert freeze_study(store, "agent-survey", TEXT, {"movingout": "new"}, {"scripted": ""}) == set()
    assert [row["pid"] for row in store.rows(participants)] == ["P1"], "nothing has changed for them"
    text = TEXT if simulated else TEXT + "# a typo\n"
    assert freeze_study(store, "agent-survey", text, {}, {"scripted": ""}, simulated) == {"P1"}
    assert (store.rows(participants), frozen_study(store).file_text) == ([], text)


def test_a_study_whose_people_were_all_purged_makes_no_place_for_another(place: Path | str) -> None:
    store = open_store(place)
    with store.database.write() as connection:
        connection.execute(insert(units).values(slot=0, state="purged", formed_ms=0))
    assert has_begun(store)
    open_store(place).close()
    with pytest.raises(StudyError, match="begin a new study with another --data folder"):
        open_store(place, text=TEXT + "# more people\n")


def test_newer_software_leaves_a_note_of_what_was_there_before_and_from_when(place: Path | str) -> None:
    clock = Clock()
    store = open_store(place, clock)
    freeze_study(store, "agent-survey", TEXT, {"movingout": "before anybody came"}, {"scripted": ""})
    agree(store, ["P1"])
    versions = ["before anybody came", "mended", "mended", "new"]
    played = []
    for version in versions:
        freeze_study(store, "agent-survey", TEXT, {"movingout": version}, {"scripted": ""})
        played.append(clock())
    found = code_by_time(store)
    assert [one["code"]["movingout"] for one in found] == ["before anybody came", "mended", "new"]
    assert [sum(one["from_ms"] <= at for one in found) for at in played] == [1, 2, 2, 3]


def test_software_that_an_earlier_version_did_not_note_is_unknown_unless_newer_software_notes_it(
    place: Path | str,
) -> None:
    store = open_store(place)
    store.audit("server", "freeze", file_sha256="", models={})  # as earlier versions did, and "code" without `before`
    assert [one["code"] for one in code_by_time(store)] == [{"movingout": "test"}]
    agree(store, ["P1"])
    freeze_study(store, "agent-survey", TEXT, {"movingout": "new"}, {"scripted": ""})
    assert [one["code"] for one in code_by_time(store)] == [{"movingout": "test"}, {"movingout": "new"}]
    store.audit("server", "freeze", file_sha256="", models={})
    store.audit("server", "code", code={"movingout": "new"})
    assert [one["code"] for one in code_by_time(store)] == [None, {"movingout": "new"}]


def test_a_study_that_has_begun_keeps_its_agents(place: Path | str) -> None:
    store = open_store(place)
    began = {"scripted": "", "dp@mine:lag=1": "ab", "onnx:path=mine.onnx": ""}
    freeze_study(store, "agent-survey", TEXT, {}, began)
    agree(store, ["P1"])
    with pytest.raises(StudyError, match="the agent dp@mine:lag=1 has changed since"):
        freeze_study(store, "agent-survey", TEXT, {}, began | {"dp@mine:lag=1": "cd"})
    # earlier versions had no hashes of files: what began then goes on
    freeze_study(store, "agent-survey", TEXT, {}, began | {"onnx:path=mine.onnx": "ef"})


def test_trained_agents_have_a_hash_with_options_and_inside_others_too(tmp_path: Path) -> None:
    network = tmp_path / "mine.onnx"
    network.write_bytes(b"weights")
    ids = [
        "dp@all",
        "dp@all:execute=4",
        "late:agent=dp@all:execute=4;lag=1,delay=2",
        f"onnx:path={network}",
        "clone:seed=3",
        "scripted",
    ]
    partners = tuple(study().partners[0].model_copy(update={"id": str(at), "agent": id}) for at, id in enumerate(ids))
    before = model_hashes(study().model_copy(update={"partners": partners}))
    assert [bool(before[id]) for id in ids] == [True, True, True, True, True, False]
    assert before[ids[0]] == before[ids[1]] == before[ids[2]] == before[ids[4]]
    network.write_bytes(b"others")
    after = model_hashes(study().model_copy(update={"partners": partners}))
    assert [id for id in ids if after[id] != before[id]] == [ids[3]]


@pytest.mark.parametrize("package_file", ["__init__", "notes"])
def test_code_of_ones_own_has_a_hash_and_is_not_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, package_file: str
) -> None:
    """Also in folders that are packages without an `__init__.py`."""
    package = tmp_path / "their" / "agents"
    package.mkdir(parents=True)
    for name in (package_file, "quick"):
        (package / f"{name}.py").write_text("raise SystemExit", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    own = study().partners[0].model_copy(update={"agent": "their.agents.quick:Quick:speed=1"})
    with_own = study().model_copy(update={"partners": (own, *study().partners)})
    before = agent_code(with_own)
    assert list(before) == ["agent:their.agents.quick:Quick:speed=1"]
    (package / "quick.py").write_text("raise SystemExit  # mended", encoding="utf-8")
    assert agent_code(with_own) != before
    assert model_hashes(with_own)[own.agent] == ""
    files = study().partners[0].model_copy(update={"agent": "onnx:path=mine.onnx"})
    assert agent_code(study().model_copy(update={"partners": (files,)})) == {}


def test_what_simulated_participants_did_is_never_mixed_with_what_people_did(place: Path | str) -> None:
    store = open_store(place)
    freeze_study(store, "agent-survey", TEXT, {}, {"scripted": ""}, simulated=True)
    assert frozen_study(store).simulated
    agree(store, ["P1"])
    with pytest.raises(StudyError, match=r"holds what simulated participants did, and people .*--rehearse 1"):
        freeze_study(store, "agent-survey", TEXT, {}, {"scripted": ""})


def test_a_study_that_has_begun_keeps_its_maps(place: Path | str) -> None:
    store = open_store(place)
    freeze_study(store, "agent-survey", TEXT, {}, {"scripted": "", "map:den.json": "ab"})
    agree(store, ["P1"])
    with pytest.raises(StudyError, match=r"the map den\.json has changed since"):
        freeze_study(store, "agent-survey", TEXT, {}, {"scripted": "", "map:den.json": "cd"})
    freeze_study(store, "agent-survey", TEXT, {}, {"scripted": "", "map:den.json": "ab", "map:unknown-then.json": "ef"})


def test_only_maps_of_ones_own_have_a_hash_and_a_new_one_when_they_change(tmp_path: Path) -> None:
    file = tmp_path / "den.json"
    text = json.dumps(map_to_json(load_map("HandOff")) | {"name": "Den", "number": 0})
    file.write_text(text, encoding="utf-8")
    own = study()
    own = own.model_copy(update={"blocks": (own.blocks[0].model_copy(update={"maps": ("HandOff:mirror", str(file))}),)})
    before = model_hashes(own)
    assert [name for name in before if name.startswith("map:")] == [f"map:{file}"]
    file.write_text(text.replace('"Den"', '"Lair"'), encoding="utf-8")
    assert model_hashes(own)[f"map:{file}"] != before[f"map:{file}"]
