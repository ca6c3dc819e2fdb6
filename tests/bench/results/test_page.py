"""The measured part of docs/results.md: tables, who is ahead of whom, and the picture."""

import shutil
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from bench import train_agents
from bench._roster import CHOOSING_BY_NFD, OF_A, OF_BOTH
from bench.results.chart import chart
from bench.results.episode_log import Outcome, Run
from bench.results.page import BEGIN, END, measured_part, write_report
from bench.results.paired_differences import against_aim, gains, lead, leads
from bench.train_agents import main
from movingout.agents.bass.accuracy import BassAccuracy
from movingout.agents.catalogue import UNSEEN_TCR
from movingout.agents.checkpoint.card import Score
from movingout.agents.checkpoint.checkpoint import SHIPPED, Checkpoint, read_checkpoint


def _outcome(agent: str, tcr: float, the_map: str = "HandOff") -> Outcome:
    return Outcome(Run(agent, "idle", the_map, 0, 0, 10), tcr, tcr / 2, 1.0, None, 0.1)


def test_the_report_replaces_what_was_measured_and_keeps_the_words_around_it(tmp_path: Path) -> None:
    page = tmp_path / "results.md"
    page.write_text(f"before\n{BEGIN}\nof before\n{END}\nafter\n")
    outcomes = [_outcome("bass@all", 0.5), _outcome("dp@all", 0.25)]
    played_of_a = {"A": [_outcome("dp@a", 0.75), _outcome("idle", 0.0)], "B": [_outcome("dp@a", 0.5)], "C": []}
    measured = measured_part((OF_BOTH, {"C": outcomes}), (OF_A, played_of_a), {}, None, "make agents")
    write_report(page, measured, "<svg/>")
    text = page.read_text()
    assert text.startswith("before\n") and text.endswith("after\n") and "of before" not in text
    assert "(results.svg)" in text and (tmp_path / "results.svg").read_text() == "<svg/>"
    assert "0.256" in text and "## With people of C" in text and "### With people of B" in text
    assert "| dp@all | DP | 0.250 | " in text
    assert "| dp@a | DP | 0.750 | 0.375 | 1 | 0.500 | 0.250 | 1 | – | – | 0 |" in text
    assert "| idle |  | 0.000 | 0.000 | 1 | – | – | 0 | – | – | 0 |" in text


def test_nothing_is_said_of_agents_trained_with_one_population_before_they_have_played() -> None:
    played = {"C": [_outcome("bass@all", 0.5)]}
    of_a = {group: [_outcome("idle", 0.0)] for group in OF_A.partners}
    text = measured_part((OF_BOTH, played), (OF_A, of_a), {}, None, "make agents")
    assert "## With people of C" in text
    assert "A alone" not in text and "people of B" not in text


def test_the_parts_of_bass_stand_beside_what_the_paper_measured() -> None:
    numbers = BassAccuracy(0.1, 0.2, 0.3, 0.4, 0.5, 0.125, 0.25, 0.6, 0.7, 0.8, 0.9, n=7)
    text = measured_part(
        (OF_BOTH, {"C": [_outcome("bass@all", 0.5)]}),
        (OF_A, {group: [] for group in "ABC"}),
        {},
        numbers,
        "make agents",
    )
    assert "| 10 % error tolerance | 0.7145 | 0.1250 |" in text and "| moments |  | 7 |" in text


def test_a_missed_target_is_said_by_how_much() -> None:
    assert "missed by 0.150" in against_aim([_outcome("bass@all", 0.5), _outcome("dp@all", 0.25)])


def test_an_agent_that_has_not_played_missed_nothing() -> None:
    said = against_aim([_outcome("dp@all", 0.25)])
    assert said == "`bass@all` has not played; the aim is a TCR of 0.65."


def _both(bass: tuple[float, float], dp: tuple[float, float]) -> list[Outcome]:
    """Of two agents on two maps."""
    played = [("bass@all", bass), ("dp@all", dp)]
    return [
        _outcome(agent, tcr, name)
        for agent, scores in played
        for tcr, name in zip(scores, ("HandOff", "LeftRight"), strict=True)
    ]


def test_a_lead_is_bold_where_the_errors_do_not_overlap() -> None:
    table = leads(OF_BOTH, {"C": _both((0.9, 0.7), (0.4, 0.2))}).splitlines()
    assert table[0] == "| | TCR | NFD | n |"
    assert table[2:] == ["| `bass@all` minus `dp@all` | **+0.500 ± 0.000** | **+0.250 ± 0.000** | 2 |"]


def test_a_lead_within_the_errors_is_not_and_neither_is_one_without_any() -> None:
    assert lead(_both((0.4, 0.8), (0.3, 0.7)), "bass@all", "dp@all", "tcr") == "+0.100 ± 0.000"
    assert lead([_outcome("bass@all", 0.5), _outcome("dp@all", 0.25)], "bass@all", "dp@all", "tcr") == "+0.250"


def test_leads_are_told_by_the_partners_population() -> None:
    played = {"A": [_outcome("bass@a", 0.5), _outcome("dp@a", 0.25)], "B": [_outcome("dp@a", 0.5)], "C": []}
    table = leads(OF_A, played).splitlines()
    assert table[0].startswith("| | people of A, trained with: TCR | NFD | n | people of B, another population: TCR |")
    assert table[2:] == ["| `bass@a` minus `dp@a` | +0.250 | +0.125 | 1 |  |  |  |"]


def test_agents_are_compared_over_the_episodes_that_both_played() -> None:
    outcomes = [_outcome("bass@all", 0.5), _outcome("dp@all", 0.25), _outcome("bass@all", 1.0, "LeftRight")]
    assert gains(outcomes, "bass@all", "dp@all", "tcr") == [0.25]


def test_the_picture_has_a_bar_for_each_agent_the_best_first() -> None:
    outcomes = [_outcome("idle", 0.0), _outcome("dp@all", 0.25), _outcome("bass@all", 0.5)]
    picture = ET.fromstring(chart(outcomes, OF_BOTH.learners))
    words = [node.text for node in picture.iter("{http://www.w3.org/2000/svg}text")]
    assert [word for word in words if word in ("idle", "dp@all", "bass@all")] == ["bass@all", "dp@all", "idle"]
    assert {"0.50", "0.25", "0.00", "aim of bass@all: 0.65", "control: these people alone"} <= set(words)
    widths = [float(node.attrib["width"]) for node in picture.iter("{http://www.w3.org/2000/svg}rect")]
    assert widths[0] == pytest.approx(2 * widths[1]) and widths[2] == 0.0


def test_bass_of_both_plays_by_nfd_when_it_is_asked_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    left_out = [
        train_agents._left_out(train_agents._parsed(["--report", "r.md", *more])) for more in ([], ["--by-nfd"])
    ]
    assert left_out == [set(CHOOSING_BY_NFD), set()]
    assert set(CHOOSING_BY_NFD) < set(OF_BOTH.learners)


def test_scores_go_into_a_card_but_not_in_place_of_more_and_not_into_what_is_shipped(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shipped = read_checkpoint(SHIPPED / "mlp-all")
    mine = Checkpoint(shutil.copytree(shipped.folder, tmp_path / "mlp-all"), shipped.card, shipped.sha256)
    now = shipped.card.scores[UNSEEN_TCR].n

    def news(checkpoint: Checkpoint, n: int) -> bool:
        return train_agents._news(checkpoint, {UNSEEN_TCR: Score(mean=0.5, stderr=0.1, n=n)})

    assert news(mine, now) and news(mine, now + 1) and not news(shipped, now + 1) and not capsys.readouterr().out
    assert not news(mine, now - 1)
    assert f"mlp@all: its card keeps its scores of {now} episodes; these are {now - 1}" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--runs", "0"], "argument --runs: must be at least 1"),
        (["--plays", "few"], "argument --plays: invalid number value: 'few'"),
        (["--report", "nowhere/results.md"], "argument --report: there is no folder nowhere"),
        (["--without", "dp@al"], "argument --without: invalid choice: 'dp@al'"),
        (["--without", "bass@all:score=nfd,sampling=4x4"], "train_agents: no agent has played with people of C yet"),
        ([], "mlp@a: not trained yet, left out of the tables"),  # most agents of the tables are not shipped
    ],
)
def test_tables_that_cannot_be_made_are_refused_in_a_sentence(
    words: list[str],
    said: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)  # where no agent was trained
    with pytest.raises(SystemExit) as ended:
        main(["--finished", "--no-parts", "--report", "results.md", *words])
    assert said in f"{ended.value.code}{''.join(capsys.readouterr())}" and not Path("results.md").exists()
