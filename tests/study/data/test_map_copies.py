"""Maps of one's own go with a study: its file in a backup or an export can be read wherever these lie."""

import json
import shutil
from pathlib import Path

import pytest

from movingout.maps import load_map, map_to_json
from movingout.server.cli import main
from movingout.study.data.backup import MANIFEST, back_up, restore
from movingout.study.data.export import Options, export_study
from movingout.study.data.map_copies import copy_own_maps
from movingout.study.design.study_file import complete_text, read_study
from movingout.study.design.templates import template_text
from tests.study.filled import fill

OWN = template_text("agent_survey").replace("HandOff,", f"maps/den.json, 'maps/den.json:mirror', {MANIFEST},")


def _study(folder: Path) -> Path:
    (folder / "maps").mkdir(parents=True)
    for file, name in (("maps/den.json", "Den"), (MANIFEST, "Manifest")):
        document = map_to_json(load_map("HandOff")) | {"name": name, "number": 0}
        (folder / file).write_text(json.dumps(document), encoding="utf-8")
    (folder / "study.yaml").write_text(OWN, encoding="utf-8")
    return folder / "study.yaml"


def test_backups_and_exports_have_the_maps_where_the_study_names_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    study = read_study(_study(tmp_path / "here"))
    place, store, _ = fill(tmp_path / "data", study, OWN, 1)
    back_up(place, tmp_path / "backup", 1_800_000_000.0)
    export_study(place, store, tmp_path / "export", Options())
    for table in ("rounds", "allocation"):
        rows = json.loads((tmp_path / "export" / f"{table}.json").read_text(encoding="utf-8"))
        named = {row["map"]: row["map_name"] for row in rows}
        assert named["maps/den.json:mirror"] == "Den:mirror" and named["PriorityPick"] == "PriorityPick", table
    shutil.rmtree(tmp_path / "here")
    monkeypatch.chdir(tmp_path / "data")
    assert read_study(tmp_path / "export" / "study.yaml").load_map("maps/den.json:mirror").name == "Den:mirror"
    assert (tmp_path / "backup" / "maps" / "den.json").is_file()
    assert restore(tmp_path / "backup", tmp_path / "restored").study == study.id, "a map called as the manifest is none"


def test_a_backup_has_the_maps_that_the_study_began_with_and_the_check_needs_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file, text = _study(tmp_path / "here"), OWN.replace(f" {MANIFEST},", "")
    file.write_text(text, encoding="utf-8")
    fill(tmp_path / "data", read_study(file), text, 1)
    file.write_text(template_text("agent_survey"), encoding="utf-8")  # the next wave is prepared in its place

    def backed_up(name: str) -> str:
        assert main(["study", "backup", str(file), "--data", str(tmp_path / "data"), "-o", str(tmp_path / name)]) == 0
        return capsys.readouterr().out

    assert "the study file has changed since the study began" in backed_up("backup")
    assert complete_text(tmp_path / "backup" / "study.yaml") == text, "so that it can be served from there"
    assert main(["study", "restore", str(tmp_path / "backup"), "--check"]) == 0
    (tmp_path / "here" / "maps" / "den.json").unlink()
    assert "cannot be read as it began" in backed_up("without")
    assert main(["study", "restore", str(tmp_path / "without"), "--check"]) == 2
    assert "maps/den.json" in capsys.readouterr().err


def test_maps_from_elsewhere_are_copied_too_and_found_from_the_copy(tmp_path: Path) -> None:
    """A study whose maps lie in a shared folder could not be read from its backup on another machine."""
    document = map_to_json(load_map("HandOff")) | {"number": 0}
    for place in ("shared/den.json", "other/den.json"):
        (tmp_path / place).parent.mkdir()
        (tmp_path / place).write_text(json.dumps(document | {"name": place[:5]}), encoding="utf-8")
    (tmp_path / "here").mkdir()
    names = ["../shared/den.json", f"{tmp_path}/other/den.json:mirror"]
    text = template_text("agent_survey").replace("HandOff,", f"{names[0]}, '{names[1]}',")
    (tmp_path / "here" / "study.yaml").write_text(text, encoding="utf-8")
    study = read_study(tmp_path / "here" / "study.yaml")
    data, _, _ = fill(tmp_path / "data", study, text, 1)
    back_up(data, tmp_path / "far" / "backup", 1_800_000_000.0)
    for gone in ("here", "shared", "other"):
        shutil.rmtree(tmp_path / gone)
    kept = read_study(tmp_path / "far" / "backup" / "study.yaml")
    assert [kept.load_map(name).name for name in names] == ["share", "other:mirror"]
    assert kept.own_maps == study.own_maps
    assert all(path.resolve().is_relative_to(tmp_path / "far") for path in (tmp_path / "far").rglob("den.json"))


def test_what_is_there_stays_as_it_is_and_what_is_gone_is_left_out(tmp_path: Path) -> None:
    study = read_study(_study(tmp_path / "here"))
    target = tmp_path / "there"
    target.mkdir()
    (target / MANIFEST).write_text("mine", encoding="utf-8")
    (tmp_path / "here" / "maps" / "den.json").unlink()
    copy_own_maps(study, target)
    assert (target / MANIFEST).read_text(encoding="utf-8") == "mine"
    assert not (target / "maps" / "den.json").exists(), "what is gone is no reason to stop"
