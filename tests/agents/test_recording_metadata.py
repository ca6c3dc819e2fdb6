"""What recordings say about agents."""

import hashlib
import json

import pytest

from movingout.agents.checkpoint.checkpoint import CARD, SHIPPED, fingerprint, read_checkpoint
from movingout.agents.recording_metadata import cards, seat_info
from movingout.recordings import SeatInfo


def test_a_trained_agent_is_named_with_the_hash_of_its_card_whatever_its_options() -> None:
    known = read_checkpoint(SHIPPED / "dp-all").sha256
    assert seat_info("dp@all:lag=2") == SeatInfo("agent", "dp@all:lag=2", known)
    assert fingerprint("dp@all") == known


def test_agents_without_a_checkpoint_have_neither_hash_nor_card() -> None:
    seats = (seat_info("scripted:seed=3"), SeatInfo("human", "dp@all"))
    assert seats[0].checkpoint_sha256 == "" == fingerprint("lost@nowhere")
    assert cards(seats) == {}


def test_cards_are_attached_by_the_colour_of_the_seat() -> None:
    (name, card), *more = cards((SeatInfo("human", "P-1"), seat_info("dp@all"))).items()
    assert (name, more) == ("card-red.json", [])
    assert json.loads(card)["id"] == "dp@all"
    assert card == (SHIPPED / "dp-all" / CARD).read_bytes()
    assert hashlib.sha256(card).hexdigest() == fingerprint("dp@all")


@pytest.mark.parametrize(
    "agent_id",
    ["late:agent=dp@all,delay=2", "clone", "late:agent=late:agent=dp@all;lag=2", "dp@all\n", " dp@all:lag=2"],
)
def test_an_agent_around_another_one_is_as_old_as_the_weights_inside_and_spaces_change_nothing(agent_id: str) -> None:
    assert fingerprint(agent_id) == fingerprint("dp@all") != ""
    assert cards((SeatInfo("agent", agent_id), SeatInfo("human", "P-1"))).keys() == {"card-blue.json"}


@pytest.mark.parametrize("agent_id", ["late", "late:delay", "clone:policy=lost@nowhere", "greedy"])
def test_an_agent_around_one_without_weights_has_no_hash(agent_id: str) -> None:
    assert fingerprint(agent_id) == ""
