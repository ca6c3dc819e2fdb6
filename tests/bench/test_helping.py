"""Whether an agent comes to whoever holds a heavy item."""

import pytest

from bench.helping import Held, Seen, main, play, rows


def test_an_expert_comes_and_brings_it_home_and_an_idle_partner_does_not() -> None:
    seen = {agent: play(Held(agent, "SingleRotation", 0, 0, 0)) for agent in ("scripted", "idle")}
    assert 0 <= seen["scripted"].held <= seen["scripted"].came < seen["scripted"].home
    assert seen["idle"].held >= 0 and seen["idle"].came == seen["idle"].home == -1


def test_the_table_counts_per_map_and_over_all() -> None:
    runs = [Held("me", name, 0, 0, 0) for name in ("HandOff", "HandOff", "SingleRotation", "SingleRotation")]
    seen = [Seen(10, 15, 40), Seen(10, 35, -1), Seen(20, -1, -1), Seen(-1, -1, -1)]
    assert rows(runs, seen) == [
        ["me", "HandOff", "2", "2", "1.5", "1", "2"],
        ["me", "SingleRotation", "1", "0", "–", "0", "2"],
        ["me", "all", "3", "2", "1.5", "1", "4"],
    ]


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--agents", "nobody"], "nobody"),
        (["--maps", "Nowhere"], "Nowhere"),
        (["--episodes", "0"], "must be at least 1"),
    ],
)
def test_what_there_is_not_is_refused_in_a_sentence(
    words: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as stopped:
        main(words)
    assert sentence in f"{stopped.value}{capsys.readouterr().err}"
