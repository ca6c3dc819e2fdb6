"""The measured part of docs/reproduction.md, and the figures that are painted."""

import contextlib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from PIL import Image

from movingout.agents.bass.recombination import RecombinedPiece
from movingout.agents.overcooked.kitchen import is_installed
from movingout.agents.training.recombined_paths import exchanged
from movingout.matches.paper.budgets import BUDGETS
from movingout.matches.paper.cells import MeasuredCell, Measurement
from movingout.matches.paper.entry import Earlier, measurements
from movingout.matches.paper.page.page_labels import IN_PART, MEASURED, PageLabel, line
from movingout.matches.paper.page.reproduction_page import BEGIN, END, write_page
from movingout.matches.paper.registry import ENTRIES
from movingout.matches.paper.rows.diversity import diversity_cell, learned_parts
from movingout.matches.paper.rows.method_rows import named_rows
from movingout.matches.paper.workspace import Workspace
from movingout.recordings.groups import grouped, write_groups
from movingout.server.cli import main
from movingout.world.estimates import Estimate
from tests.agents.learning import recorded, walked

SMOKE = BUDGETS["smoke"]


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.chdir(tmp_path)
    yield tmp_path


def _row(page: Path, label: str) -> list[str]:
    (line,) = (one for one in page.read_text(encoding="utf-8").splitlines() if one.startswith(f"| `{label}` |"))
    return [cell.strip() for cell in line.strip("|").split(" | ")]


def test_a_page_gets_a_row_for_every_label_and_the_numbers_that_are_there(here: Path) -> None:
    space, page = Workspace(budget=SMOKE), here / "page.md"
    space.keep("noise-by-episode-0.2", {"valid_share": Estimate(0.5, 0.1, 20)})
    space.note_time("measure validity of states of SingleRotation with pose noise 0.2", 40.0)
    space.note_time("measure validity of states of SingleRotation with pose noise 0.2", 20.0)
    page.write_text(f"# Page\n{BEGIN}\nstale\n{END}\nafter\n", encoding="utf-8")
    write_page(page, ENTRIES.values(), space, "2026-11-23")
    text = page.read_text(encoding="utf-8")
    assert text.startswith("# Page\n") and text.endswith("after\n") and "stale" not in text
    assert _row(page, "tab:pose_noise_ablation")[1:6] == [
        "measured in part", "smoke, 2026-11-23", "C1 valid (↑): 0.2 0.5000 ± 0.1000 (0.0002)", "20", "60 s",
    ]  # fmt: skip
    assert _row(page, "mappo_parameters")[1:3] == ["a definition", "–"]
    assert _row(page, "mappo_parameters")[3] == "24 of 29 settings are the paper's"
    assert _row(page, "tab:ablation")[1:4] == ["not measured with this budget", "–", "–"]
    assert _row(page, "fig:failure_cases")[1] == "needs people"
    assert _row(page, "text:overcooked")[1] == ("not measured with this budget" if is_installed() else "not built")
    assert _row(page, "fig:visual_task2")[1] == "not drawn yet"
    assert all(f"| `{label}` |" in text for label in ENTRIES)
    assert "### Ablation of different pose-noise levels" in text and "### Ablations" not in text
    before = text
    write_page(page, ENTRIES.values(), space, "2026-11-23")
    assert page.read_text(encoding="utf-8") == before


def test_a_cell_that_the_paper_leaves_empty_too_is_not_missing(here: Path) -> None:
    space, page, label = Workspace(budget=SMOKE), here / "page.md", "text:augmentation"
    page.write_text(f"{BEGIN}\n{END}\n", encoding="utf-8")
    assert ENTRIES[label].state == "whole"
    empty = [cell for cell in ENTRIES[label].cells() if cell.without_number]
    assert [(cell.row.name, cell.column.measure) for cell in empty] == [("Recorded", "valid_share")]
    status = []
    for one in measurements([ENTRIES[label]]):
        write_page(page, [ENTRIES[label]], space, "2026-11-24")
        status.append(_row(page, label)[1])
        space.keep(one.name, {"entropy": Estimate(0.9, 0.1, 20), "valid_share": Estimate(0.9, 0.1, 20)})
    write_page(page, [ENTRIES[label]], space, "2026-11-24")
    parts = ["measured in part"] * 2
    assert [*status, _row(page, label)[1]] == ["not measured with this budget", *parts, "measured"]


def test_a_page_keeps_what_it_has_with_a_bigger_budget_or_with_more_numbers(here: Path) -> None:
    page, label = here / "page.md", "tab:pose_noise_ablation"
    page.write_text(f"{BEGIN}\n{END}\n", encoding="utf-8")

    def written(budget: str, day: str, *levels: str, share: float = 0.5) -> list[str]:
        folder = here / day
        folder.mkdir()
        with contextlib.chdir(folder):
            space = Workspace(budget=BUDGETS[budget])
            for level in levels:
                space.keep(f"noise-by-episode-{level}", {"valid_share": Estimate(share, 0.1, 20)})
            write_page(page, ENTRIES.values(), space, day)
        return _row(page, label)

    assert written("smoke", "Monday", "0.2", "0.02")[2] == "smoke, Monday"
    assert written("smoke", "Tuesday", "0.2")[2] == "smoke, Monday", "more numbers"
    assert written("smoke", "Wednesday")[2] == "smoke, Monday"
    assert written("small", "Thursday", "0.2")[2] == "small, Thursday", "a bigger budget"
    assert written("smoke", "Friday", "0.2", "0.02")[2] == "small, Thursday"
    assert written("small", "Saturday", "0.2")[2] == "small, Thursday", (
        "the same numbers are of the day they were measured"
    )
    assert written("small", "Sunday", "0.2", share=0.4)[2] == "small, Sunday", "as many, and newer"
    assert written("small", "next Monday", "0.2", "0.02")[2] == "small, next Monday"
    assert written("paper-size", "next Tuesday", "0.2")[2] == "small, next Monday", "fewer numbers"
    assert written("paper-size", "next Wednesday", "0.2", "0.02")[2] == "paper-size, next Wednesday"
    assert written("small", "next Thursday", "0.2", "0.02")[2] == "paper-size, next Wednesday"
    assert page.read_text(encoding="utf-8").count("### Ablation of different pose-noise levels") == 1


def test_a_page_keeps_what_stands_on_more_trainings_or_matches(here: Path) -> None:
    page, measurement = (
        here / "page.md",
        Measurement("known", "what is known", lambda space, training: {}, repeated=True),
    )
    rows = named_rows(BASS=lambda column: MeasuredCell(measurement, "share"))
    entry = replace(ENTRIES["text:partner_prediction"], rows=rows)
    page.write_text(f"{BEGIN}\n{END}\n", encoding="utf-8")

    def written(budget: str, day: str, trainings: int, mean: float = 0.5, n: int = 48) -> list[str]:
        folder = here / day
        folder.mkdir()
        with contextlib.chdir(folder):
            space = Workspace(budget=replace(BUDGETS[budget], trainings=trainings))
            for training in range(trainings):
                numbers = {"share": Estimate(mean + training / 10, 0.1, n // trainings)}
                space.keep(measurement.name_of(training), numbers)
            write_page(page, [entry], space, day)
        return _row(page, entry.label)

    row = written("small", "Monday", 3)
    assert row[2] == "small, Monday, 3 trainings" and "(trainings ± " in row[3]
    assert written("small", "Tuesday", 1, 0.7)[2] == row[2], "never without the error between trainings"
    assert written("small", "Wednesday", 2, 0.7)[2] == row[2]
    text = page.read_text(encoding="utf-8")
    page.write_text(text.replace(", 3 trainings", ""), encoding="utf-8")  # as pages of before
    assert written("small", "Thursday", 1, 0.7)[2] == "small, Monday"
    assert written("small", "Friday", 3, 0.7, 36)[2] == "small, Friday, 3 trainings"
    assert written("small", "Saturday", 3, 0.6, 33)[2] == "small, Saturday, 3 trainings", "counted otherwise"
    assert written("small", "Sunday", 3, 0.6, 15)[2] == "small, Saturday, 3 trainings", "a larger n"
    assert written("paper-size", "next Monday", 1)[2] == "paper-size, next Monday", "a bigger budget"
    assert written("small", "next Tuesday", 3)[2] == "paper-size, next Monday"


def test_more_trainings_of_a_part_do_not_replace_the_whole(here: Path) -> None:
    def label(status: str, day: str) -> PageLabel:
        return PageLabel(line(["`tab:ablation`", status, day, "C1 TCR: BASS 0.5", "72", "5 min", ""]))

    whole, part = label(MEASURED, "medium, Monday"), label(IN_PART, "medium, Tuesday, 3 trainings")
    assert whole.is_better_than(part) and not part.is_better_than(whole)
    assert label(MEASURED, "medium, Tuesday, 3 trainings").is_better_than(whole)


def test_a_label_of_which_something_lacks_is_measured_in_part(here: Path) -> None:
    page, entry = here / "page.md", ENTRIES["text:partner_prediction"]
    measurement = Measurement("known", "what is known", lambda space, training: {})
    whole = replace(entry, rows=named_rows(BASS=lambda column: MeasuredCell(measurement, "share")))
    page.write_text(f"{BEGIN}\n{END}\n", encoding="utf-8")
    space = Workspace(budget=SMOKE)
    space.keep("known", {"share": Estimate(0.5, 0.1, 20)})
    write_page(page, [whole], space, "Monday")
    assert _row(page, entry.label)[1] == "measured"
    lacking = replace(whole, lacks="bars of people need a study")
    (here / "new").mkdir()
    with contextlib.chdir(here / "new"):
        write_page(page, [lacking], space, "Tuesday")
    assert _row(page, entry.label)[1:3] == ["measured in part", "smoke, Monday"]
    assert _row(page, entry.label)[6] == f"{entry.differs}; bars of people need a study"
    page.write_text(f"{BEGIN}\n{END}\n", encoding="utf-8")
    write_page(page, [lacking], space, "Wednesday")
    assert _row(page, entry.label)[1:3] == ["measured in part", "smoke, Wednesday"]


def test_what_a_page_keeps_is_said_in_todays_words(here: Path) -> None:
    page, entry = here / "page.md", ENTRIES["tab:pose_noise_ablation"]
    page.write_text(f"{BEGIN}\n{END}\n", encoding="utf-8")
    before = replace(
        entry, title="As it was called", differs="as it was", notes=("Long ago.",), otherwise="not made",
        rows={key: cells for key, cells in entry.rows.items() if key != ("", "0.2")},
    )  # fmt: skip
    space = Workspace(budget=BUDGETS["small"])
    for level in ("0.02", "0.2"):
        space.keep(f"noise-by-episode-{level}", {"valid_share": Estimate(0.25, 0.1, 20)})
    write_page(page, [before], space, "Monday")
    old = page.read_text(encoding="utf-8")
    assert "As it was called" in old and "| as it was; 0.2: not made |" in old
    (here / "new").mkdir()
    with contextlib.chdir(here / "new"):
        other = Workspace(budget=SMOKE)
        other.keep("noise-by-episode-0.02", {"valid_share": Estimate(0.75, 0.1, 20)})
        write_page(page, [entry], other, "Tuesday")
    text = page.read_text(encoding="utf-8")
    assert _row(page, entry.label)[1:3] == ["measured in part", "small, Monday"]
    assert _row(page, entry.label)[6] == entry.differs
    assert f"### {entry.heading} (`{entry.label}`)" in text and "Long ago" not in text and entry.notes[0] in text
    with contextlib.chdir(here / "new"):
        write_page(page, [replace(entry, rows={}, differs="without its extra")], other, "Wednesday")
    assert page.read_text(encoding="utf-8") == text, "what cannot be made here keeps its numbers and its words"
    lines = [line.split(" | ")[:5] for line in text.splitlines() if line.startswith("| 0.")]
    assert lines[2] == ["| 0.02", "0.043", "0.040", "0.2500 ± 0.1000", "0.3501"], "numbers as they were"
    assert lines[3] == ["| 0.2", "0.43", "0.400", "not measured", "0.0002"], "new rows have none of another folder"


def test_numbers_that_were_measured_otherwise_before_a_day_say_so_until_they_are_measured_again(here: Path) -> None:
    page, entry = here / "page.md", ENTRIES["tab:pose_noise_ablation"]
    entry = replace(entry, earlier=Earlier("2026-11-28", "It was in fewer states."))
    page.write_text(f"{BEGIN}\n{END}\n", encoding="utf-8")

    def written(day: str, budget: str) -> str:
        with contextlib.chdir(here):
            space = Workspace(budget=BUDGETS[budget])
            space.keep("noise-by-episode-0.2", {"valid_share": Estimate(0.5, 0.1, len(day + budget))})
            write_page(page, [entry], space, day)
        return page.read_text(encoding="utf-8")

    assert entry.notes[0] in written("2026-11-27", "small")
    assert f"{entry.notes[0]} It was in fewer states." in written("2026-11-29", "smoke")
    assert f"{entry.notes[0]} It was in fewer states." in written("2026-11-30", "smoke"), "kept again"
    assert "fewer states" not in written("2026-11-28", "medium")
    assert "fewer states" not in written("2026-11-30", "smoke"), "kept, and measured as today"


def test_numbers_that_were_measured_otherwise_give_way_to_as_many_of_today_with_a_smaller_n(here: Path) -> None:
    page, entry = here / "page.md", ENTRIES["tab:pose_noise_ablation"]
    entry = replace(entry, earlier=Earlier("2026-11-28", "It was in fewer states."))
    page.write_text(f"{BEGIN}\n{END}\n", encoding="utf-8")

    def written(day: str, n: int, *levels: str, budget: str = "small") -> list[str]:
        (here / day).mkdir()
        with contextlib.chdir(here / day):
            space = Workspace(budget=BUDGETS[budget])
            for level in levels:
                space.keep(f"noise-by-episode-{level}", {"valid_share": Estimate(0.5, 0.1, n)})
            write_page(page, [entry], space, day)
        return _row(page, entry.label)

    both = "0.02", "0.2"
    assert written("2026-11-26", 200, *both)[2] == "small, 2026-11-26"
    assert written("2026-11-27", 20, *both)[2] == "small, 2026-11-26", "both are of before"
    assert written("2026-11-28", 20, "0.2")[2] == "small, 2026-11-26", "fewer numbers"
    assert written("2026-11-29", 20, *both, budget="smoke")[2] == "small, 2026-11-26"
    assert written("2026-11-30", 20, *both)[2:5:2] == ["small, 2026-11-30", "20"]
    assert written("2026-12-01", 10, *both)[2] == "small, 2026-11-30", "both are of today"


def test_a_page_says_who_played_the_given_recordings(here: Path) -> None:
    page, label = here / "page.md", "tab:pose_noise_ablation"
    space = Workspace(budget=SMOKE, given=(here,))
    space.keep("noise-by-episode-0.2", {"valid_share": Estimate(0.5, 0.1, 20)})
    people = recorded(here, "people", 9, kinds=("human", "agent"))
    simulated = recorded(here, "simulated", 9, kinds=("human", "human"), simulated=True)
    agents = recorded(here, "agents", 9, kinds=("agent", "agent"))
    for files, who in (
        ([people], "people"), ([agents], "agents"), ([simulated], "simulated participants"),
        ([simulated, people, agents], "people and simulated participants"),
    ):  # fmt: skip
        page.write_text(f"{BEGIN}\n{END}\n", encoding="utf-8")
        write_groups(space.listing("c1"), grouped(files, 1))
        write_page(page, [ENTRIES[label]], space, "2026-11-28")
        assert _row(page, label)[2] == f"smoke, 2026-11-28, {who}"


def test_sizes_of_data_sets_are_a_definition_whatever_recordings_were_given(here: Path) -> None:
    page, label = here / "page.md", "text:data_sets"
    page.write_text(f"{BEGIN}\n{END}\n", encoding="utf-8")
    write_page(page, [ENTRIES[label]], Workspace(budget=SMOKE), "2026-11-28")
    text, space = page.read_text(encoding="utf-8"), Workspace(budget=SMOKE, given=(here,))
    assert _row(page, label)[1:4] == ["a definition", "–", "5 of 6 settings are the paper's"]
    write_page(page, [ENTRIES[label]], space, "2026-11-29")
    assert page.read_text(encoding="utf-8") == text, "where they have not been counted"
    for challenge in ("c1", "c2"):
        write_groups(space.listing(challenge), grouped([recorded(here, challenge, 9, kinds=("human", "human"))], 1))
        write_page(page, [ENTRIES[label]], space, "2026-11-29")
        assert page.read_text(encoding="utf-8") == text, "where they have"


def test_the_command_writes_the_page_of_a_folder(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (here / "out").mkdir()
    page = here / "page.md"
    page.write_text(f"{BEGIN}\n{END}\n", encoding="utf-8")
    assert main(["paper", "page", "page.md", "-o", "out"]) == 2
    assert "no table has been made in" in capsys.readouterr().err
    assert main(["paper", "page", "page.md", "-o", "nowhere"]) == 2
    assert "there is no folder nowhere" in capsys.readouterr().err
    (here / "out" / "paper.json").write_text(
        '{"budget": "smoke", "evaluation": "official", "data": [], "min_tcr": 0.0, "seed": 0}', encoding="utf-8"
    )
    assert main(["paper", "page", "page.md", "-o", "out"]) == 0
    assert "| label | status | budget, day |" in page.read_text(encoding="utf-8")
    page.write_text("no place", encoding="utf-8")
    assert main(["paper", "page", "page.md", "-o", "out"]) == 2
    assert "has no place to write to" in capsys.readouterr().err


def test_a_folder_without_its_given_recordings_is_told_which_command_lists_them(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "page.md").write_text(f"{BEGIN}\n{END}\n", encoding="utf-8")
    begun = '{"budget": "smoke", "evaluation": "official", "data": ["/elsewhere"], "min_tcr": 0.0, "seed": 0}'
    (here / "paper.json").write_text(begun, encoding="utf-8")
    listing = here / Workspace(budget=SMOKE).listing("c1")
    write_groups(listing, grouped([recorded(here, "moved", 9)], 1))
    (here / "moved.mcap").unlink()
    assert main(["paper", "page", "page.md", "-o", "."]) == 2
    said = "moved.mcap, which is not there: `movingout paper tables LABEL -o "
    assert said in capsys.readouterr().err


def test_a_figure_without_numbers_is_painted(here: Path) -> None:
    assert main(["paper", "figures", "fig:visual_task2", "--budget", "smoke", "-o", "out"]) == 0
    picture = Image.open(here / "out" / "figures" / "fig_visual_task2.png")
    assert picture.size[0] > 5 * 220 and len(set(picture.convert("L").tobytes())) > 10
    assert "fig_visual_task2.png" in (here / "out" / "figures" / "fig_visual_task2.md").read_text(encoding="utf-8")


def test_diversity_is_measured_of_the_listed_episodes_and_copies_give_no_error(here: Path) -> None:
    files = [recorded(here / "theirs", f"{number}", 20, number, (f"a{number}", f"b{number}")) for number in range(3)]
    space = Workspace(budget=SMOKE, given=(here / "theirs",))
    write_groups(space.listing("c1"), grouped(files, 1))
    cell = diversity_cell("c1", "entropy")
    assert cell.found(space) is None
    space.keep(cell.measurement.name, cell.measurement.perform(space, 0))
    found = cell.found(space)
    assert found is not None and found.estimate is not None
    assert found.estimate.n == 3 and 0.0 < found.estimate.mean < 1.0 and found.estimate.stderr is not None


def test_a_recombined_path_is_the_partners_of_the_other_episode_from_the_piece_on() -> None:
    own, other = walked(ticks=30), walked(ticks=20, seed=1)
    (blue, _, *_) = learned_parts([own, other], Workspace(budget=SMOKE))
    path = exchanged(RecombinedPiece(blue, 10, other, 5))
    assert path.shape == (10 + 16, 4)
    assert (path[:, :2] == own.robot_poses[:26, 0, :2]).all()
    assert (path[:10, 2:] == own.robot_poses[:10, 1, :2]).all()
    assert (path[10:, 2:] == other.robot_poses[5:21, 1, :2]).all()
