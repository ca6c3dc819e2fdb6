"""`movingout recordings diversity` as a user types it."""

import csv
import json
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from movingout.agents.bass.recombination import Matching
from movingout.maps import load_map
from movingout.matches.paper.budgets import BUDGETS
from movingout.matches.paper.rows.diversity import augmented_cell, diversity_cell
from movingout.matches.paper.workspace import Workspace
from movingout.recordings import SeatInfo, finalise
from movingout.recordings.diversity.episodes import ALL, populations, read_paths
from movingout.recordings.exports import export
from movingout.recordings.exports.plan import ExportPlan
from movingout.recordings.groups import grouped, write_groups
from movingout.server.cli import main
from tests.agents.learning import recorded
from tests.recordings.support import record

pytestmark = pytest.mark.slow


def people(blue: str, red: str) -> tuple[SeatInfo, SeatInfo]:
    return SeatInfo("human", blue), SeatInfo("human", red)


def played(folder: Path, name: str, map_name: str, blue: str, red: str, seed: int, **more: Any) -> Path:
    path = finalise(
        record(folder, ticks=12, episode_id=name, map_name=map_name, seats=people(blue, red), seed=seed, **more)[0]
    )
    return path


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two pairs on two maps, with a copy of one episode, and one that does not count."""
    folder = tmp_path_factory.mktemp("recordings")
    for seed in (1, 2, 3):
        played(folder, f"one-{seed}", "HandOff", "P1", "P2", seed=min(seed, 2))
    for seed in (4, 5, 6):
        played(folder, f"two-{seed}", "HandOff", "P3", "P4", seed=seed)
    for seed in (4, 5):
        played(folder, f"left-{seed}", "LeftRight", "P1", "P2", seed=seed)
    played(folder, "two-left", "LeftRight", "P4", "P3", seed=6)
    played(folder, "broken-off", "HandOff", "P1", "P2", seed=7, outcome="left")
    return folder


def test_people_and_the_simulated_ones_of_a_rehearsal_are_two_populations(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for seed in (1, 2):
        played(tmp_path, f"people-{seed}", "HandOff", "P1", "P2", seed=seed)
        played(tmp_path, f"programs-{seed}", "HandOff", "P3", "P4", seed=seed, study={"simulated": "yes"})
    document, _ = measured(capsys, str(tmp_path), "--by", "agent")
    assert {"people", "simulated people"} <= set(json.dumps(document).split('"'))


def measured(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[dict[str, Any], str]:
    assert main(["recordings", "diversity", "--json", "--workers", "1", *words]) == 0
    said = capsys.readouterr()
    return json.loads(said.out), said.err


def test_groups_are_compared_with_equally_many_episodes(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found, said = measured(capsys, str(data), "--by", "group", "--draws", "4")
    rows = {(row["map"], row["population"]): row for row in found["maps"]}
    counts = {key: (row["episodes"], row["distinct"], row["drawn"]) for key, row in rows.items()}
    assert counts == {
        ("HandOff", "P1+P2"): (3, 2, 3),
        ("HandOff", "P3+P4"): (3, 3, 3),
        ("HandOff", "all together"): (6, 5, 3),
        ("LeftRight", "P1+P2"): (2, 2, 0),
        ("LeftRight", "P3+P4"): (1, 1, 0),
        ("LeftRight", "all together"): (3, 3, 3),
    }
    assert rows["LeftRight", "P3+P4"]["dtw_mean"] is None  # too few to be measured
    overall = {row["population"]: row["maps"] for row in found["overall"]}
    assert overall == {"P1+P2": 1, "P3+P4": 1, "all together": 1}  # only HandOff has three of everybody
    assert "left out: 1 unfinished" in said and found["left_out"]["unfinished"] == 1


def test_styles_are_compared_and_those_who_mixed_them(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    styles = tmp_path / "styles.csv"
    styles.write_text("participant,style\nP1,leads\nP2,leads\nP3,leads\nP4,follows\n", encoding="utf-8")
    found, _ = measured(capsys, str(data), "--by", "style", "--styles", str(styles), "--map", "HandOff")
    counts = {row["population"]: row["episodes"] for row in found["maps"]}
    assert counts == {"leads": 3, "follows+leads": 3, "all together": 6}
    assert main(["recordings", "diversity", str(data), "--by", "style"]) == 2
    assert "4 of 4 participants have no style (P1, P2, P3, P4)" in capsys.readouterr().err
    assert main(["recordings", "diversity", str(data), "--styles", str(styles)]) == 2
    assert "counts with --by style alone" in capsys.readouterr().err


def test_all_episodes_are_measured_when_asked_for(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found, _ = measured(capsys, str(data), "--by", "group", "--counts", "all", "--map", "HandOff")
    everybody = next(row for row in found["maps"] if row["population"] == "all together")
    assert everybody["drawn"] == 6 and everybody["dtw_mean_stderr"] > 0 and everybody["entropy_stderr"] > 0


def test_different_maps_of_one_name_are_measured_apart(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """As the recordings from before and after a map file was edited."""
    den = replace(load_map("HandOff"), name="Den", number=0)
    edited = replace(den, items=den.items[:1])
    widened = replace(den, walls=den.walls[:1])
    for number, the_map in enumerate((den, edited, den, replace(widened, variant="varied", items=den.items[:1]))):
        recorded(tmp_path, f"e{number}", ticks=9, the_map=the_map)
    recorded(tmp_path, "e4", ticks=9, the_map=widened)
    found, _ = measured(capsys, str(tmp_path), "-o", str(tmp_path / "out"))
    assert [(row["map"], row["episodes"]) for row in found["maps"]] == [("Den.1", 2), ("Den.2", 1), ("Den.3", 2)]
    firsts = "Den.1 is that of e0.mcap, Den.2 is that of e1.mcap, Den.3 is that of e3.mcap."
    assert found["method"].endswith(f"3 different maps are called Den: {firsts}")
    assert firsts in (tmp_path / "out" / "diversity.md").read_text()
    assert (tmp_path / "out" / "positions-Den.2.png").exists()
    recorded(tmp_path / "alone", "one", ticks=9, the_map=den)
    recorded(tmp_path / "alone", "two", ticks=9, the_map=replace(edited, variant="varied"))
    found, _ = measured(capsys, str(tmp_path / "alone"))
    assert [(row["map"], row["episodes"]) for row in found["maps"]] == [("Den", 2)]
    assert "called" not in found["method"]


def test_one_challenge_is_measured_without_the_other(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name, variant in (("one", ""), ("two", ""), ("three", "varied")):
        recorded(tmp_path, name, ticks=9, the_map=replace(load_map("HandOff"), variant=variant))
    for words, count in (((), 3), (("--challenge", "1"), 2), (("--challenge", "2"), 1)):
        found, _ = measured(capsys, str(tmp_path), *words)
        assert [row["episodes"] for row in found["maps"]] == [count]


def test_copies_and_folders_named_twice_are_measured_once(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Every other command counts an episode once."""
    inner = tmp_path / "day"
    shutil.copytree(data, inner)
    shutil.copy(inner / "two-4.mcap", tmp_path / "backup.mcap")
    once, _ = measured(capsys, str(data), "--by", "group")
    both, said = measured(capsys, str(tmp_path), str(inner), "--by", "group")
    assert both["maps"] == once["maps"]
    assert both["left_out"] == once["left_out"] | {"copies": 11}
    assert "left out: 1 unfinished, 11 copies" in said


def test_populations_by_place_may_overlap(data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A folder that was named after one that holds it had nothing left."""
    inner = tmp_path / "day"
    shutil.copytree(data, inner)
    reading = read_paths([tmp_path, inner, inner / ".." / "day"], workers=1, by_place=True)
    groups = populations(reading.episodes, "place")
    alone = read_paths([inner], workers=1).episodes
    assert [len(groups[name]) for name in (str(inner), str(tmp_path), ALL)] == [len(alone)] * 3
    assert reading.copies == 0


@pytest.mark.parametrize("by_place", [True, False])
def test_official_files_under_two_places_are_measured_once(data: Path, tmp_path: Path, by_place: bool) -> None:
    """All together had them twice, as had every other population."""
    inner = tmp_path / "official" / "day"
    inner.parent.mkdir()
    export("official", ExportPlan(sorted(data.glob("two-?.mcap")), inner))
    reading = read_paths([inner.parent, inner], workers=1, by_place=by_place)
    groups = populations(reading.episodes, "place" if by_place else "agent")
    assert sorted(map(len, groups.values())) == ([3, 3, 3] if by_place else [3])
    assert reading.copies == (0 if by_place else 3)


def test_official_files_are_measured_like_the_recordings_that_they_come_from(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    files = sorted(data.glob("two-?.mcap"))
    export("official", ExportPlan(files, tmp_path / "official"))
    official, _ = measured(capsys, str(tmp_path / "official"))
    ours, _ = measured(capsys, *map(str, files), "--by", "group")
    numbers = ("episodes", "distinct", "dtw_mean", "dtw_variance", "entropy", "coverage")
    (first,), (second,) = official["maps"], ours["maps"]
    assert [first[name] for name in numbers] == pytest.approx([second[name] for name in numbers], rel=0.05)


def test_a_folder_has_the_tables_and_a_picture_per_map(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for style in ("dots", "trails", "heat"):
        target = tmp_path / style
        assert main(["recordings", "diversity", str(data), "--by", "group", "-o", str(target), "--plot", style]) == 0
        names = {path.name for path in target.iterdir()}
        pictures = {"positions-HandOff.png", "positions-LeftRight.png"}
        assert names == {"diversity.md", "maps.csv", "populations.csv"} | pictures
        with Image.open(target / "positions-HandOff.png") as picture:
            assert picture.size == (3 * 332 + 12, 320 + 34 + 24)
            assert len(picture.getcolors(100_000) or []) > 20  # neither blank nor one colour
    with (tmp_path / "dots" / "maps.csv").open(encoding="utf-8") as stream:
        assert len(list(csv.DictReader(stream))) == 6
    assert "wrote" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["nothing-there"], "there is nothing at nothing-there; check the name"),
        (["{empty}"], "there are no recordings in {empty}: neither *.mcap nor official"),
        (["{data}", "--map", "HandOf"], "no finished episode on HandOf; maps here: HandOff, LeftRight"),
        (["{data}", "-o", "{empty}"], "{empty} exists already and is not overwritten"),
        (["{data}", "--challenge", "2"], "no finished episode is on maps that are varied"),
        (["{data}/broken-off.mcap"], "no finished episode was found (1 unfinished)"),
    ],
)
def test_what_cannot_be_measured_is_refused_in_a_sentence(
    words: list[str], sentence: str, data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    places = {"data": data, "empty": tmp_path}
    assert main(["recordings", "diversity", *(word.format(**places) for word in words)]) == 2
    assert sentence.format(**places) in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--points", "1"], "--points: it must be from 2 to 1000"),
        (["--points", "300000"], "--points: it must be from 2 to 1000"),
        (["--grid", "200000"], "--grid: it must be from 2 to 500"),
        (["--seed", "-1"], "--seed: it must be from 0 to"),
        (["--bandwidth", "0"], "--bandwidth: a width is above 0"),
        (["--by", "grup"], "--by: unknown value 'grup'"),
    ],
)
def test_options_that_mean_nothing_are_refused(
    words: list[str], sentence: str, data: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["recordings", "diversity", str(data), *words])
    assert sentence in capsys.readouterr().err


def test_one_participant_alone_has_nobody_to_be_compared_with(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for seed in (1, 2, 3):
        seats = (SeatInfo("human", "P9"), SeatInfo("agent", "scripted"))
        finalise(record(tmp_path, ticks=12, episode_id=f"alone-{seed}", seats=seats, seed=seed)[0])
    found, said = measured(capsys, str(tmp_path), "--by", "participant")
    assert "there is only one population by participant, P9: nothing to compare it with" in said
    assert [row["population"] for row in found["overall"]] == ["P9"]


def test_recordings_without_names_cannot_be_grouped_by_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    finalise(record(tmp_path, ticks=12, seats=people("", ""))[0])
    assert main(["recordings", "diversity", str(tmp_path), "--by", "participant"]) == 2
    assert "no recording names its participants, so --by participant is impossible" in capsys.readouterr().err


def test_episodes_that_name_nobody_are_counted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """They were in no row but the last one, without a word."""
    for seed in range(3):
        played(tmp_path, f"named-{seed}", "HandOff", "P1", "P2", seed=seed)
        played(tmp_path, f"nameless-{seed}", "HandOff", "", "", seed=seed + 3)
    found, said = measured(capsys, str(tmp_path), "--by", "participant")
    assert "movingout: 3 episodes name nobody and are in “all together” alone\n" in said
    assert found["nameless"] == 3 and {row["population"]: row["episodes"] for row in found["overall"]}[ALL] == 6
    _, said = measured(capsys, str(tmp_path), "--by", "group")
    assert "3 episodes name nobody and are left out" in said, "there is one group alone"
    found, said = measured(capsys, str(tmp_path), "--by", "kind")
    assert found["nameless"] == 0 and "name nobody" not in said


def driven(folder: Path, name: str, blue: float, red: float, map_name: str = "FourCorners") -> Path:
    """20 ticks straight ahead at these distances."""
    the_map = load_map(map_name)
    actions = np.zeros((20, 2, 3))
    actions[:, :, 0] = blue, red
    actions[:, :, 1] = [pose.angle for pose in the_map.robots]
    return recorded(folder, name, people=(f"{name}b", f"{name}r"), the_map=the_map, actions=actions)


@pytest.fixture(scope="module")
def ahead(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """In all episodes blue drives alike, and red does not."""
    folder = tmp_path_factory.mktemp("ahead")
    return [driven(folder, f"e{number}", 0.2, 0.05 * number) for number in range(4)]


def test_recombined_ones_are_those_of_the_tables(
    ahead: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    space = Workspace(budget=BUDGETS["smoke"])
    write_groups(space.listing("c1"), grouped(ahead, 1))
    place = str(ahead[0].parent)
    words = ("--augmented", "--pieces", str(space.budget.states), "--seed", str(space.seed), "--counts", "all")
    found, said = measured(capsys, place, *words)
    recorded_row, *rows = found["overall"]
    names = [place, f"{place}, recombined", f"{place}, recombined, single-agent"]
    assert [row["population"] for row in found["overall"]] == names
    assert [row["population"] for row in found["maps"]] == names
    assert [row["episodes"] for row in found["maps"]] == [4, 20, 20]
    plain = diversity_cell("c1", "entropy").measurement.perform(space, 0)
    assert recorded_row["entropy"] == plain["entropy"].mean and recorded_row["valid_share"] is None
    matchings: tuple[Matching, ...] = ("both-ends", "either-end")
    for row, matching in zip(rows, matchings, strict=True):
        table = augmented_cell(matching, "entropy").measurement.perform(space, 0)
        measures = ("dtw_mean", "dtw_variance", "entropy", "coverage")
        ours = [(row[name], row[f"{name}_stderr"]) for name in measures]
        assert ours == [(table[name].mean, table[name].stderr) for name in measures]
        assert (row["valid_share"], row["valid_share_stderr"], row["pieces"]) == table["valid_share"]
        assert row["pieces"] > 1
    assert found["not_recombined"] == [] and "recombined" not in said


def test_recorded_rows_stay_and_recombined_ones_are_of_as_many(
    ahead: list[Path], capsys: pytest.CaptureFixture[str]
) -> None:
    place = str(ahead[0].parent)
    for words in ((place, "--by", "agent"), (*map(str, ahead[:3]), str(ahead[0].parent))):
        plain, _ = measured(capsys, *words, "--draws", "3")
        found, _ = measured(capsys, *words, "--draws", "3", "--augmented", "--pieces", "4")
        both = {row["population"]: row for row in found["maps"]}
        assert [both[row["population"]] for row in plain["maps"]] == plain["maps"]
        assert {row["drawn"] for row in both.values()} == {row["drawn"] for row in plain["maps"]}


def test_what_cannot_be_recombined_is_said(
    ahead: list[Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    one_each = [ahead[0], driven(tmp_path, "other", 0.2, 0.1, "HandOff")]
    found, said = measured(capsys, *map(str, one_each), "--by", "source", "--augmented")
    sentence = (
        "scripted, recombined: nothing can be recombined; that takes two episodes of a map, and there is one of each"
    )
    assert f"movingout: {sentence}\n" in said and sentence in found["not_recombined"]
    assert [row["population"] for row in found["overall"]] == ["scripted"]
    assert found["overall"][0]["pieces"] is None
    found, said = measured(capsys, *map(str, [*ahead, one_each[1]]), "--by", "source", "--augmented", "--pieces", "2")
    assert "scripted, recombined: nothing was recombined on HandOff; what was recorded there stands alone" in said
    elsewhere = [ahead[0], recorded(tmp_path, "slow", ticks=7, the_map=load_map("FourCorners"))]
    _, said = measured(capsys, *map(str, elsewhere), "--by", "source", "--augmented")
    assert "nothing can be recombined; no two episodes of a map have a matching stretch" in said
    assert main(["recordings", "diversity", str(ahead[0]), "--pieces", "3"]) == 2
    assert "--pieces counts with --augmented alone" in capsys.readouterr().err


def test_tables_and_pictures_have_recombined_ones_and_official_files_do_too(
    ahead: list[Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    export("official", ExportPlan(ahead, tmp_path / "official"))
    words = [str(tmp_path / "official"), "--augmented", "--pieces", "5", "-o", str(tmp_path / "out"), "--workers", "1"]
    assert main(["recordings", "diversity", *words]) == 0
    assert "| valid | pieces |" in capsys.readouterr().out
    for name in ("maps", "populations"):
        with (tmp_path / "out" / f"{name}.csv").open(encoding="utf-8") as stream:
            rows = list(csv.DictReader(stream))
        assert [row["population"].partition(", ")[2] for row in rows] == ["", "recombined", "recombined, single-agent"]
    assert [bool(row["valid_share"]) for row in rows] == [False, True, True]
    page = (tmp_path / "out" / "diversity.md").read_text(encoding="utf-8")
    assert "± is the binomial standard error" in page
    with Image.open(tmp_path / "out" / "positions-FourCorners.png") as picture:
        assert picture.size[0] == 3 * 332 + 12  # a panel for each
