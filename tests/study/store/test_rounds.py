"""What is kept of the players of a round."""

from pathlib import Path

import pytest

from movingout.study.store.rounds import PlayerOutcome, RoundOutcome, Rounds
from movingout.study.store.tables import players
from tests.study.support import agree, open_store, rounds_of

CUT_SHORT = RoundOutcome("interrupted", 50, 0.0, 0.0, 0.0, None)


@pytest.mark.parametrize("before", ["gamepad", ""])
def test_the_device_that_a_restarted_server_does_not_know_is_that_of_the_round_before(
    tmp_path: Path, before: str
) -> None:
    store = open_store(tmp_path)
    agree(store, ["P1"])
    unit, played = store.form_unit(["P1"]), Rounds(store)
    first, second, third = rounds_of(unit.slot)[:3]
    played.begin(unit, first, "a", [PlayerOutcome("P1", 0, before)])
    played.begin(unit, second, "b", [PlayerOutcome("P1", 0, "")])
    played.end("b", CUT_SHORT, [PlayerOutcome("P1", 0, "", idle_share=0.5)], recovered=True)
    played.leave_out(unit, third, [PlayerOutcome("P1", 0, "")])
    assert [row["device"] for row in store.rows(players)] == [before] * 3


def test_the_device_that_was_pressed_counts_for_later_rounds_too(tmp_path: Path) -> None:
    store = open_store(tmp_path)
    agree(store, ["P1"])
    unit, played = store.form_unit(["P1"]), Rounds(store)
    first, second = rounds_of(unit.slot)[:2]
    played.begin(unit, first, "a", [PlayerOutcome("P1", 0, "keyboard")])
    played.end("a", CUT_SHORT, [PlayerOutcome("P1", 0, "touch")])
    played.begin(unit, second, "b", [PlayerOutcome("P1", 0, "")])
    assert [row["device"] for row in store.rows(players)] == ["touch", "touch"]
