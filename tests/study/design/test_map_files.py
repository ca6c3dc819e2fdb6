"""Maps of one's own lie beside the study file, whatever folder a command is given in."""

import json
import re
from pathlib import Path
from unicodedata import normalize

import pytest

from movingout.maps import load_map, map_to_json
from movingout.study.data.map_copies import copy_own_maps
from movingout.study.data.study_folder import StudyFolder
from movingout.study.data.versions import model_hashes
from movingout.study.design.review import map_warnings
from movingout.study.design.study_file import complete_text, parse_study, read_study
from movingout.study.design.templates import template_text
from movingout.study.errors import StudyFileError
from movingout.study.store.frozen_study import freeze_study
from tests.study.support import open_store

OWN = template_text("agent_survey").replace("HandOff,", "maps/den.json, 'maps/den.json:mirror',")


@pytest.fixture
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, in which nothing lies."""
    folder = tmp_path / "elsewhere"
    folder.mkdir()
    monkeypatch.chdir(folder)
    return folder


def write_map(folder: Path, name: str = "Den") -> None:
    """maps/den.json in a folder."""
    (folder / "maps").mkdir(parents=True)
    document = map_to_json(load_map("HandOff")) | {"name": name, "number": 0}
    (folder / "maps" / "den.json").write_text(json.dumps(document), encoding="utf-8")


def write_study(folder: Path, text: str = OWN) -> Path:
    folder.mkdir(exist_ok=True)
    file = folder / "study.yaml"
    file.write_text(text, encoding="utf-8")
    return file


def test_a_map_lies_beside_the_study_whatever_the_current_folder(tmp_path: Path, elsewhere: Path) -> None:
    file = write_study(tmp_path / "study")
    with pytest.raises(StudyFileError, match=r"blocks\[0\].maps: cannot read the map file maps/den.json"):
        read_study(file)
    write_map(tmp_path / "study")
    study = read_study(file)
    assert study.own_maps == ("maps/den.json", "maps/den.json:mirror"), "data have the names of the file"
    assert [study.load_map(name).name for name in (*study.own_maps, "LeftRight")] == ["Den", "Den:mirror", "LeftRight"]
    assert [name for name in model_hashes(study) if name.startswith("map:")] == [f"map:{one}" for one in study.own_maps]
    (tmp_path / "study" / "maps" / "den.json").write_text(
        json.dumps(map_to_json(study.load_map("maps/den.json")) | {"number": 3}), encoding="utf-8"
    )
    assert any(f"{tmp_path}/study/maps/den.json" in one for one in map_warnings(study)), "hints are those of this file"


def test_a_study_that_began_with_a_map_of_the_current_folder_goes_on(tmp_path: Path, elsewhere: Path) -> None:
    file = write_study(tmp_path / "study")
    write_map(elsewhere)
    before = parse_study(OWN)  # as earlier versions read it
    store = open_store(tmp_path, text=OWN)
    freeze_study(store, before.id, OWN, {}, model_hashes(before))
    store.arrive("P1", "en")
    freeze_study(store, before.id, OWN, {}, model_hashes(read_study(file)))
    assert StudyFolder(before, tmp_path).as_frozen(store, file.parent).study == read_study(file)


def test_the_map_beside_the_study_comes_first(tmp_path: Path, elsewhere: Path) -> None:
    write_map(elsewhere, "Loft")
    write_map(tmp_path / "study")
    study = read_study(write_study(tmp_path / "study"))
    assert study.load_map("maps/den.json").name == "Den"
    (elsewhere / "HandOff").write_text("{}")
    assert study.map_source("HandOff") == "HandOff", "shipped maps have their names to themselves"


def test_a_map_whose_name_macos_wrote_is_found_by_the_name_that_people_type(tmp_path: Path, elsewhere: Path) -> None:
    write_map(tmp_path / "study")
    lies, typed = normalize("NFD", "maps/höhle.json"), normalize("NFC", "maps/höhle.json")
    (tmp_path / "study" / "maps" / "den.json").rename(tmp_path / "study" / lies)
    study = read_study(write_study(tmp_path / "study", OWN.replace("maps/den.json", typed)))
    assert study.own_maps == (typed, f"{typed}:mirror"), "data have the names of the file"
    assert [study.load_map(name).name for name in study.own_maps] == ["Den", "Den:mirror"]
    copy_own_maps(study, elsewhere)
    assert (elsewhere / typed).is_file()


def test_a_study_with_texts_and_maps_in_files_is_kept_whole(tmp_path: Path, elsewhere: Path) -> None:
    write_map(tmp_path / "study")
    (tmp_path / "study" / "title.txt").write_text("Ours", encoding="utf-8")
    file = write_study(
        tmp_path / "study", re.sub(r"^title:\n  en:.*", "title:\n  en: {file: title.txt}", OWN, flags=re.M)
    )
    assert "Ours" in complete_text(file)
