"""A study that has begun is run with the same file, models and kind of participants to its end."""

import json
from pathlib import Path

import pytest

from movingout.maps import load_map, map_to_json
from movingout.study.data.versions import model_hashes
from movingout.study.errors import StudyError
from movingout.study.store.frozen_study import freeze_study, frozen_study
from movingout.study.store.tables import audit
from tests.study.support import TEXT, open_store, study


def test_a_study_that_has_begun_keeps_its_file_and_its_models(place: Path | str) -> None:
    store = open_store(place)
    open_store(place, text=TEXT + "# before anybody came\n").close()
    store.arrive("P1", "en")
    with pytest.raises(
        StudyError, match="study agent-survey has begun, and its file or a text beside it has changed since"
    ):
        open_store(place, text=TEXT)
    with pytest.raises(StudyError, match="a model has changed since"):
        freeze_study(store, "agent-survey", TEXT + "# before anybody came\n", {}, {"scripted": "ab"})
    freeze_study(store, "agent-survey", TEXT + "# before anybody came\n", {"movingout": "mended"}, {"scripted": ""})
    assert frozen_study(store).code == {"movingout": "mended"}
    assert [row["action"] for row in store.rows(audit)] == ["freeze", "freeze", "arrive", "code"]


def test_what_simulated_participants_did_is_never_mixed_with_what_people_did(place: Path | str) -> None:
    store = open_store(place)
    freeze_study(store, "agent-survey", TEXT, {}, {"scripted": ""}, simulated=True)
    assert frozen_study(store).simulated
    store.arrive("P1", "en")
    with pytest.raises(StudyError, match=r"holds what simulated participants did, and people .*--rehearse 1"):
        freeze_study(store, "agent-survey", TEXT, {}, {"scripted": ""})


def test_a_study_that_has_begun_keeps_its_maps(place: Path | str) -> None:
    store = open_store(place)
    freeze_study(store, "agent-survey", TEXT, {}, {"scripted": "", "map:den.json": "ab"})
    store.arrive("P1", "en")
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
