"""The table of diversity: ours beside the paper's."""

import pytest

from bench.diversity import main


def test_ours_stand_beside_the_papers(capsys: pytest.CaptureFixture[str]) -> None:
    main(["--maps", "SingleRotation", "--people", "4", "--ticks", "4", "--workers", "1"])
    rows = capsys.readouterr().out.splitlines()
    assert [row.split(" | ")[0] for row in rows[2:9]] == [
        *("| A", "| B", "| C", "| all"),
        *("| paper: Moving Out Challenge 1", "| paper: Expert dataset", "| paper: RL agent collected data"),
    ]
    assert rows[6] == "| paper: Moving Out Challenge 1 | 7.013 | 6.065 | 0.888 | 0.899 |"
    assert rows[-1] == "Maps: 1. Per population 2 pairs, one episode of up to 4 ticks on each map."


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--maps", "HandOf"], "unknown map 'HandOf'"),
        (["--people", "2"], "--people must be an even number from 4 to 20"),
        (["--people", "22"], "--people must be an even number from 4 to 20"),
        (["--ticks", "0"], "--ticks and --workers must be at least 1"),
    ],
)
def test_what_cannot_be_played_is_refused_in_a_sentence(
    words: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["--workers", "1", *words])
    assert ended.value.code == 2 and said in capsys.readouterr().err
