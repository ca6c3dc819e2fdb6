"""What a table needs comes in an order in which it can be done, is done once, and is refused in sentences."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from movingout.maps import load_map, map_names
from movingout.matches.callbacks import no_op
from movingout.matches.commands import paper
from movingout.matches.errors import MatchError
from movingout.matches.match import Match
from movingout.matches.paper import match_store
from movingout.matches.paper.budgets import BUDGETS
from movingout.matches.paper.data_sets import list_episodes, map_remedy
from movingout.matches.paper.entry import played_cells
from movingout.matches.paper.other_games import overcooked
from movingout.matches.paper.presentation.bar_chart import bar_chart
from movingout.matches.paper.presentation.latex_table import latex
from movingout.matches.paper.presentation.layout import laid_out
from movingout.matches.paper.presentation.writers import html, markdown
from movingout.matches.paper.registry import ENTRIES
from movingout.matches.paper.rows import measurements
from movingout.matches.paper.steps import paper_steps
from movingout.matches.paper.workspace import Workspace
from movingout.recordings.errors import RecordingError
from movingout.recordings.groups import read_groups
from movingout.server.cli import main
from movingout.world.estimates import Estimate
from tests.agents.learning import recorded
from tests.matches.paper.test_match_store import played_result

SMOKE = BUDGETS["smoke"]


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.chdir(tmp_path)
    yield tmp_path


def _abouts(label: str, **changes: object) -> list[str]:
    space = Workspace(budget=SMOKE, **changes)  # type: ignore[arg-type]
    return [step.about for step in paper_steps([ENTRIES[label]], space)]


def test_steps_come_in_an_order_in_which_they_can_be_done(here: Path) -> None:
    assert _abouts("tab:cross_group_eval") == [
        "record scripted people for Challenge 1",
        "list the episodes of Challenge 1 and divide their participants",
        "train dp@a (dp)",
        "train dp@b (dp)",
        "train dp-augmented@a (dp)",
        "train bass@a (bass)",
        "train dp-augmented@b (dp)",
        "train bass@b (bass)",
        "play 96 matches",
    ]


def test_given_recordings_are_not_recorded_again(here: Path) -> None:
    assert _abouts("tab:cross_group_eval", given=(here,))[0].startswith("list the episodes")


def test_full_trains_three_times(here: Path) -> None:
    space = Workspace(budget=BUDGETS["full"])
    steps = [step.about for step in paper_steps([ENTRIES["tab:nfd_vs_ac"]], space)]
    assert [about for about in steps if about.startswith("train bass")] == [
        f"train bass@c1{seed} (bass)" for seed in ("", "-1", "-2")
    ]
    assert steps[-1] == f"play {3 * 2 * 12 * 20:,} matches"


def test_matches_that_are_left_are_counted_and_take_their_time(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def play(matches: list[Match], **options: Any) -> None:
        for match in matches:
            options["on_result"](played_result(match))

    monkeypatch.setattr(match_store, "play_matches", play)
    label, grown = [ENTRIES["tab:nfd_vs_ac"]], replace(SMOKE, seeds=4)
    whole = paper_steps(label, Workspace(budget=grown))[-1]
    assert whole.about == "play 96 matches"
    space = Workspace(budget=SMOKE)
    paper_steps(label, space)[-1].perform(no_op)
    rest = paper_steps(label, Workspace(budget=grown))[-1]
    assert rest.about == "play 72 of 96 matches" and rest.seconds == pytest.approx(0.75 * whole.seconds)
    assert paper_steps(label, space)[-1].is_done()


def test_challenge_2_is_evaluated_on_designed_maps_or_on_held_out_combinations(here: Path) -> None:
    cell = played_cells([ENTRIES["fig:results_t2"]])[0]
    official = cell.matches(Workspace(budget=SMOKE))
    held_out = cell.matches(Workspace(budget=SMOKE, evaluation="held-out"))
    assert {match.challenge for match in official} == {1} and {match.challenge for match in held_out} == {2}
    assert tuple(match.map for match in official) == map_names()


def test_measurements_are_kept(here: Path) -> None:
    space = Workspace(budget=SMOKE)
    assert space.measured("noise-by-episode-0.2") is None
    space.keep("noise-by-episode-0.2", {"valid_share": Estimate(0.5, 0.1, 20)})
    assert space.measured("noise-by-episode-0.2") == {"valid_share": Estimate(0.5, 0.1, 20)}
    table = laid_out(ENTRIES["tab:pose_noise_ablation"], space)
    assert table.rows[-1] == ("0.2", "0.43", "0.400", "0.5000 ± 0.1000", "0.0002", "not measured", "0.0000", "20")
    assert "| 0.5000 ± 0.1000 | 0.0002 |" in markdown(table)
    assert r"\textbf{0.43}" not in latex(table) and r"0.5000 & 0.1000 & 0.0002" in latex(table)
    assert r"\label{tab:pose_noise_ablation}" in latex(table)
    assert "<td>0.5000 ± 0.1000</td>" in html(table)


def test_changes_stand_beside_what_they_are_relative_to(here: Path) -> None:
    rows = laid_out(ENTRIES["tab:cross_group_eval"], Workspace(budget=SMOKE)).rows
    assert rows[2][:3] == ("Cross-Group: DP", "not measured", "0.2563 (-20.72 %)")


def test_a_figure_has_a_bar_for_each_number_of_the_paper_before_anything_is_played(here: Path) -> None:
    picture = bar_chart(ENTRIES["fig:results_t2"], Workspace(budget=SMOKE))
    assert picture.count('class="theirs"') == 4 * 5, "AC beside both of ours"
    assert 'class="ours"' not in picture
    assert picture.count('class="error"') == 4 * 5 and "DP/BASS" in picture


@pytest.mark.parametrize(
    ("people", "ticks", "sentence"),
    [
        ([("a", "b")], 20, "2 groups need 2 participants or pairs"),
        ([("a", "b"), ("c", "d")], 20, "group 1 of Challenge 1 has no episode on PassOrSplit"),
        ([("a", "b"), ("c", "d")], 3, "2 episodes have 6 frames together, too few to learn from"),
    ],
)
def test_recordings_that_no_table_can_be_made_from_are_refused(
    people: list[tuple[str, str]], ticks: int, sentence: str, here: Path
) -> None:
    for number, pair in enumerate(people):
        recorded(here / "theirs", f"{number}", ticks=ticks, people=pair)
    space = Workspace(budget=SMOKE, given=(here / "theirs",))
    with pytest.raises((MatchError, RecordingError), match=sentence):
        list_episodes(1, space)
    with pytest.raises(MatchError, match="on a varied map, which Challenge 2 learns from"):
        list_episodes(2, space)


def test_what_may_help_where_a_group_lacks_a_map_fits_what_was_asked_for(here: Path) -> None:
    def refused(challenge: int = 1, **options: Any) -> str:
        return map_remedy(challenge, Workspace(budget=SMOKE, given=(here,), **options))

    assert refused() == "record them, or divide the participants otherwise with another --seed"
    assert refused(min_tcr=0.5).startswith("record them, or keep poorer episodes with a --min-tcr below 0.5, or divide")
    assert refused(grouping="style") == "record them, or divide the participants otherwise with other --styles"
    assert refused(challenge=2) == "record them"
    for number, pair in enumerate([("a", "b"), ("c", "d")]):
        recorded(here / "theirs", f"{number}", ticks=20, people=pair)
    with pytest.raises(MatchError, match=r"each of the twelve maps: record them$"):  # which nobody played
        list_episodes(1, Workspace(budget=SMOKE, given=(here / "theirs",)))


def test_groups_by_style_are_all_of_one_against_all_of_another(here: Path) -> None:
    pairs = ("A01", "A02"), ("B01", "B02"), ("A03", "B03")
    for name in map_names():
        for number, pair in enumerate(pairs):
            recorded(here / "theirs", f"{name}-{number}", ticks=20, people=pair, the_map=load_map(name))
    space = Workspace(budget=SMOKE, given=(here / "theirs",), grouping="style")
    list_episodes(1, space)
    people = {group: {who for row in read_groups(space.listing("c1")) if row.group == group for who in row.people}
              for group in (1, 2)}  # fmt: skip
    assert people == {1: {"A01", "A02"}, 2: {"B01", "B02"}}
    assert "styles of play" in markdown(laid_out(ENTRIES["tab:cross_group_eval"], space))
    assert "styles of play" not in markdown(laid_out(ENTRIES["fig:results_t2"], space))
    styled = tuple((who, style) for pair, style in zip(pairs, ("one", "two", "three"), strict=True) for who in pair)
    with pytest.raises(MatchError, match=r"compare 2 groups, and these recordings have 3 styles \(one, three, two\)"):
        list_episodes(1, Workspace(budget=SMOKE, given=(here / "theirs",), grouping="style", styles=styled))


def test_the_command_refuses_in_sentences(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for words, sentence in (
        (["tab:ablatoin"], "did you mean tab:ablation?"),
        (["fig:failure_cases"], "is not made by this command: needs people"),
        (["tab:ablation", "--data", "nowhere"], "there are no recordings at nowhere"),
        (["tab:ablation", "--styles", "who.csv"], "counts with --groups style alone; add that"),
        (["tab:ablation", "--groups", "style", "--styles", "who.csv"], "cannot read who.csv"),
        (["tab:ablation", "--min-tcr", "0.1"], "--min-tcr leaves out poor episodes of --data"),
        (["tab:ablation", "--workers", "0"], "--workers is at least 1"),
        (["tab:ablation", "--seed", f"{2**29}"], "--seed from 0 to 536,870,911"),
        (["tab:ablation", "--trainings", "0"], "--trainings is at least 1"),
    ):
        assert main(["paper", "tables", *words]) == 2
        assert sentence in capsys.readouterr().err
    assert list(here.iterdir()) == []


@pytest.mark.parametrize(
    ("asked", "sentence"),
    [
        (("figures", "tab:ablation"), "tab:ablation is a table: `movingout paper tables tab:ablation` makes it"),
        (("figures", "text:augmentation"), "a sentence: `movingout paper tables text:augmentation` makes it"),
        (("tables", "fig:visual_task2"), "is a figure: `movingout paper figures fig:visual_task2` makes it"),
    ],
)
def test_a_label_is_made_by_the_command_for_its_kind(
    here: Path, capsys: pytest.CaptureFixture[str], asked: tuple[str, str], sentence: str
) -> None:
    for dry in ([], ["--dry-run"]):
        assert main(["paper", *asked, *dry]) == 2
        assert sentence in capsys.readouterr().err
    assert list(here.iterdir()) == []


def test_of_all_labels_one_that_cannot_be_made_is_named_and_the_others_are_made(
    here: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def carried_out(steps: object, space: Workspace, where: str) -> None:
        if where.startswith("tab:ablation"):
            raise MatchError("none of 3 recordings is on a varied map")

    monkeypatch.setattr(paper, "carry_out", carried_out)
    assert main(["paper", "tables", "all", "--budget", "smoke", "-o", "out"]) == 1
    assert "tab:ablation was not made: none of 3 recordings is on a varied map" in capsys.readouterr().err
    tables = {path.stem for path in (here / "out" / "tables").iterdir()}
    assert "tab_sampling_comparison" in tables and "tab_ablation" not in tables


def test_of_all_labels_one_that_needs_an_extra_is_named_where_it_is_not_installed(
    here: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(overcooked, "is_installed", lambda: False)
    monkeypatch.setattr(paper, "carry_out", lambda steps, space, where: None)
    assert main(["paper", "tables", "all", "--budget", "smoke", "-o", "out"]) == 1
    said = capsys.readouterr().err
    assert "text:overcooked was not made" in said and "[overcooked]'" in said
    assert main(["paper", "tables", "text:overcooked", "--budget", "smoke", "-o", "out"]) == 2


def test_a_dry_run_says_what_would_be_done_and_leaves_nothing(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["paper", "tables", "tab:nfd_vs_ac", "--dry-run", "--budget", "smoke", "-o", "out"]) == 0
    shown = capsys.readouterr().out
    assert "train bass@c1 (bass)" in shown and "5 steps to do, 0 done; about" in shown
    assert list(here.iterdir()) == []


def test_a_dry_run_refuses_recordings_that_the_run_would_refuse(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (here / "junk.mcap").write_text("no recording", encoding="utf-8")
    dry = ["--data", "junk.mcap", "--dry-run", "--budget", "smoke", "-o", "out"]
    assert main(["paper", "tables", "tab:nfd_vs_ac", *dry]) == 2
    sentence = f"{here / 'junk.mcap'}: junk.mcap is not an MCAP file"
    assert sentence in capsys.readouterr().err
    assert main(["paper", "tables", "mappo_parameters", *dry]) == 0, "which needs no recordings"
    capsys.readouterr()
    assert main(["paper", "tables", "all", *dry]) == 1
    shown = capsys.readouterr()
    assert f"tab:nfd_vs_ac cannot be made: {sentence}" in shown.err
    trained = [line for line in shown.out.splitlines() if "train " in line]
    assert trained and all("train mappo-6" in line for line in trained), "text:sparse_reward needs no recordings"
    assert "mappo_parameters" not in shown.err and {path.name for path in here.iterdir()} == {"junk.mcap"}


def test_a_dry_run_refuses_a_folder_that_was_begun_with_something_else(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table = ["paper", "tables", "mappo_parameters", "-o", "out", "--budget", "smoke"]
    assert main(table) == 0
    assert main([*table, "--seed", "1", "--dry-run"]) == 2
    assert "was begun with seed 0; choose another folder" in capsys.readouterr().err


def test_the_list_has_every_label(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["paper", "list"]) == 0
    shown = capsys.readouterr().out
    assert all(label in shown for label in ENTRIES)
    states = [line.partition("made")[0] for line in shown.splitlines() if "made here" in line]
    assert len({len(start) for start in states if "some" not in start}) == 1, "in one column, however long a label is"


def test_each_decision_that_is_timed_is_made_anew(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    calls: list[str] = []

    class Deciding:
        def reset(self, episode: object) -> None:
            calls.append("reset")

        def act(self, observation: object) -> None:
            calls.append("act")

    monkeypatch.setattr(measurements, "load_agent", lambda agent_id: Deciding())
    found = measurements.decision_time("bass", "").measurement.perform(Workspace(budget=SMOKE), 0)
    assert calls == ["reset", "act"] * (1 + measurements.DECISIONS)
    assert found["decision_ms"].n == measurements.DECISIONS
