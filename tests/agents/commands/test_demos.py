"""`movingout demos …` as a user types it."""

import json
from pathlib import Path

import pytest

from movingout.agents.data.demonstrations import episode_jobs
from movingout.agents.data.repeats import folder_sentences, repeats_sentence
from movingout.agents.scripted.populations import population
from movingout.maps import load_map, map_to_json
from movingout.server.cli import main

MAPS = "HandOff:mirror,LeftRight,generated:awareness:20000,HandOff:rot90,generated:awareness:20001"
LABEL = ["demos", "label", "--learner", "idle", "--expert", "idle", "--map", MAPS, "--ticks", "4", "--workers", "1"]


def test_the_page_has_a_line_per_group_of_maps_and_the_document_every_map(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*LABEL, "--episodes", "2", "-o", str(tmp_path / "page")]) == 0
    head, *lines = capsys.readouterr().out.splitlines()
    assert head.startswith("wrote 10 episodes to ")
    assert lines == [
        "  HandOff                TCR 0.00  4 episodes on 2 maps",
        "  LeftRight              TCR 0.00  2 episodes",
        "  generated:awareness    TCR 0.00  4 episodes on 2 maps",
    ]
    assert main([*LABEL, "--episodes", "1", "-o", str(tmp_path / "document"), "--json"]) == 0
    assert sorted(json.loads(capsys.readouterr().out)["tcr"]) == sorted(MAPS.split(","))


@pytest.mark.parametrize(("who", "said"), [("C", 1), ("people:C", 1), ("B", 0)])
def test_labels_with_people_who_are_for_tests_are_told_of(
    who: str, said: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    few = ["--map", "HandOff", "--episodes", "1", "--ticks", "4", "--workers", "1", "-o", str(tmp_path)]
    assert main(["demos", "label", "--learner", "idle", "--expert", "idle", "--population", who, *few]) == 0
    assert capsys.readouterr().err.count("people of C are for tests") == said


@pytest.mark.parametrize(
    "command",
    [
        ["demos", "label", "--out", "out"],
        ["demos", "generate", "--out", "out"],
        ["demos", "generate", "--challenge", "2", "--variants", "1", "--out", "out"],
        ["agents", "weakness", "idle", "--out", "out"],
        ["train", "mappo"],
        ["train", "self-play"],
        ["train", "response", "--base", "dp@any", "--partners", "idle"],
    ],
)
def test_a_map_that_is_delivered_from_the_start_is_refused(
    command: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Labels without a tick blocked a training, recordings ended in a traceback, and self-play learned nothing."""
    monkeypatch.chdir(tmp_path)
    document = map_to_json(load_map("Simple")) | {
        "name": "Done",
        "goals": [{"x0": -1.2, "y0": 1.2, "x1": 1.2, "y1": -1.2}],
    }
    (tmp_path / "done.json").write_text(json.dumps(document))
    assert main([*command, "--map", str(tmp_path / "done.json")]) == 2
    assert "on Done all items lie in a goal from the start, so there is nothing to play" in capsys.readouterr().err
    assert [file.name for file in tmp_path.iterdir()] == ["done.json"]


def test_nobody_is_refused_as_one_is(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """It was taken for the default: all people played on all maps."""
    few = ["--map", "HandOff", "--episodes", "1", "--ticks", "2", "--workers", "1"]
    assert main(["demos", "generate", "--people", "0", *few, "-o", str(tmp_path / "out")]) == 2
    assert "--people must be an even number from 2 to 20, not 0" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_split_without_variants_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["demos", "generate", "--split", "official", "-o", str(tmp_path / "out")]) == 2
    assert "--split is of variants, which --challenge 2 has" in capsys.readouterr().err


def test_the_document_has_no_rate_of_episodes_that_were_there_already(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    few = ["--map", "HandOff", "--episodes", "1", "--ticks", "2", "--workers", "1", "-o", str(tmp_path), "--json"]
    documents = []
    for _ in range(2):
        assert main(["demos", "generate", "--people", "2", *few]) == 0
        documents.append(json.loads(capsys.readouterr().out))
    assert [(one["episodes"], one["already"], one["mean_tcr"]) for one in documents] == [(1, 0, 0.0), (0, 1, None)]


def test_episodes_that_are_there_already_under_another_name_are_told_of(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """With `--seed 1` half of the new data were copies, from which training learns twice."""
    few = ["--people", "2", "--map", "HandOff", "--episodes", "4", "--ticks", "1", "--workers", "1"]
    (tmp_path / "torn.mcap").write_bytes(b"nothing")
    said = []
    for seed in ("0", "0", "1", "4"):
        assert main(["demos", "generate", *few, "-o", str(tmp_path), "--seed", seed]) == 0
        said.append([line for line in capsys.readouterr().err.splitlines() if "repeat" in line])
    assert said == [
        [],
        [],
        [
            f"movingout: 2 episodes have the map, seats and seed of others in {tmp_path} and will repeat them; "
            "--seed 4 makes new ones"
        ],
        [],
    ]


def test_a_run_that_goes_on_opens_no_recording_of_its_own_to_look_for_repeats(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With ten thousand of them it was silent for many seconds before it began."""
    opened: list[Path] = []

    def opens(path: Path) -> dict[str, dict[str, str]]:
        opened.append(path)
        return {}

    monkeypatch.setattr("movingout.agents.data.repeats.read_metadata", opens)
    jobs = episode_jobs(population("A")[:2], [load_map("HandOff")], 3, 1, seed=0, prefix="a")
    for name in (jobs[0].episode_id, jobs[1].episode_id, "of-another-run"):
        (tmp_path / f"{name}.mcap").touch()
    assert repeats_sentence(jobs, tmp_path) == ""
    assert opened == [tmp_path / "of-another-run.mcap"]


def test_recordings_of_other_runs_are_told_of_before_they_are_opened(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With ten thousand of them it was silent for many seconds before it began."""
    opened: list[Path] = []

    def opens(path: Path) -> dict[str, dict[str, str]]:
        opened.append(path)
        return {}

    monkeypatch.setattr("movingout.agents.data.repeats.read_metadata", opens)
    jobs = episode_jobs(population("A")[:2], [load_map("HandOff")], 2, 1, seed=0, prefix="a")
    assert list(folder_sentences(jobs, tmp_path)) == []
    for number, name in enumerate((jobs[0].episode_id, "of-another-run", "and-another")):
        (tmp_path / f"{name}.mcap").touch()
        are = ("", "1 recording of other runs is in {}; it is", "2 recordings of other runs are in {}; they are")[
            number
        ]
        said = folder_sentences(jobs, tmp_path)
        assert next(said, "") == (f"{are.format(tmp_path)} kept, and training takes all" if are else "")
    assert opened == []
    assert list(said) == [] and len(opened) == 2


@pytest.mark.parametrize("action", ["generate", "label"])
@pytest.mark.parametrize("number", [["--seed", "-1"], ["--seed", str(2**53)], ["--ticks", "36001"]])
def test_numbers_that_cannot_be_are_answered_in_a_sentence(
    action: str, number: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A seed below 0 ended in a traceback."""
    few = ["--map", "Simple", "--challenge", "2", "--episodes", "1", "--workers", "1", "-o", str(tmp_path / "out")]
    assert main(["demos", action, *few, *number]) == 2
    assert (
        "--ticks is at most 36000, and --seed is a whole number from 0 to 9007199254740991" in capsys.readouterr().err
    )
    assert not (tmp_path / "out").exists()


def test_proving_says_what_the_file_has_and_not_what_was_asked_for(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "maps.txt"
    modes = ("coordination", "awareness", "awareness", "consistency")
    path.write_text("".join(f"generated:{mode}:{20_000 + at} 100\n" for at, mode in enumerate(modes)))
    command = ["demos", "prove", "--split", "training", "--count", "1", "-o", str(path)]
    assert main(command) == 0
    assert capsys.readouterr().out == (
        f"0 of 0 maps tried were solved; {path} has 1 of coordination, 2 of awareness, 1 of action consistency\n"
    )
    assert main([*command, "--json"]) == 0
    maps = {"coordination": 1, "awareness": 2, "action consistency": 1}
    assert json.loads(capsys.readouterr().out) == {"out": str(path), "tried": 0, "solved": 0, "maps": maps}
