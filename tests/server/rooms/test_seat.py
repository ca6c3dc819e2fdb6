"""What a seat says about itself in a recording."""

from movingout.agents.checkpoint.checkpoint import fingerprint
from movingout.recordings import SeatInfo
from movingout.server.rooms.seat import Seat


def test_a_trained_agent_is_recorded_with_the_hash_of_its_weights() -> None:
    assert Seat(1, "agent", "dp@all").info() == SeatInfo("agent", "dp@all", fingerprint("dp@all"))
    assert len(fingerprint("dp@all")) == 64


def test_people_are_recorded_by_alias_and_an_empty_seat_as_idle() -> None:
    assert Seat(0, "human", alias="P-7", name="Ada").info() == SeatInfo("human", "P-7")
    assert Seat(0, "idle").info() == SeatInfo("idle", "idle")
