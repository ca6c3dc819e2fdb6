"""Limits per address: whom they count together, and whom they never hit."""

import asyncio

import pytest

from movingout.server.connection import admission
from movingout.server.connection.admission import LEAST_BYTES, ROUND_BYTES, AdmissionControl, Secret, address_group
from movingout.server.connection.connection_limits import ConnectionLimits
from movingout.server.settings import Limits


class Clock:
    """A clock that only moves when told to."""

    now = 0.0

    def __call__(self) -> float:
        return self.now


def control(clock: Clock | None = None, **limits: int) -> AdmissionControl:
    return AdmissionControl(Limits(**limits), clock or Clock())


def guesses(gate: AdmissionControl, address: str, secret: Secret) -> bool:
    return asyncio.run(gate.guesses_too_often(address, secret))


@pytest.mark.parametrize(
    ("one", "other", "together"),
    [
        ("192.0.2.1", "192.0.2.2", False),
        ("2001:db8:1:2::1", "2001:db8:1:2:ffff::9", True),
        ("2001:db8:1:2::1", "2001:db8:1:3::1", False),
        ("::ffff:192.0.2.1", "192.0.2.1", True),
        ("fe80::1%eth0", "fe80::2%eth1", True),
        ("", "unix", False),
    ],
)
def test_an_ipv6_network_counts_as_one_address(one: str, other: str, together: bool) -> None:
    assert (address_group(one) == address_group(other)) == together


def test_all_addresses_of_a_network_share_their_rooms() -> None:
    gate = control(rooms_per_address_per_minute=2)
    for count in range(2):
        address = f"2001:db8::{count + 1}"
        assert gate.may_open_room(address)
        gate.opened_room(gate.owner(address), f"room-{count}")
    assert not gate.may_open_room("2001:db8::77")
    assert gate.rooms_of("2001:db8::5") == {"room-0", "room-1"}
    gate.closed_room("room-0")
    gate.closed_room("never opened here")
    assert gate.rooms_of("2001:db8::5") == {"room-1"}
    gate.closed_room("room-1")
    assert gate.rooms_of("2001:db8::5") == frozenset()


def test_all_addresses_of_a_network_share_their_checks_of_maps() -> None:
    gate = control(map_checks_per_minute=1, map_solves_per_minute=1)
    assert [gate.may_check_map(f"2001:db8::{last}") for last in range(3)] == [True, False, False]
    assert [gate.may_solve_map(f"2001:db8::{last}") for last in range(3)] == [True, False, False]


def test_a_room_that_is_being_opened_counts_until_it_is_open_or_was_refused() -> None:
    gate = control()
    gate.opening_began("2001:db8::1")
    gate.opening_began("2001:db8::2")
    owner = gate.owner("2001:db8::2")
    gate.opened_room(owner, "room")
    gate.opening_ended("2001:db8::2")
    assert gate.being_opened("2001:db8::3") == 1
    assert gate.rooms_by_owner() == {owner: (1, frozenset({"room"}))}
    gate.opening_ended("2001:db8::1")
    assert gate.being_opened("2001:db8::3") == 0
    gate.closed_room("room")
    assert gate.rooms_by_owner() == {}


def test_a_recording_of_a_few_ticks_counts_as_a_file_does() -> None:
    gate = AdmissionControl(Limits(recorded_per_address_per_day=ROUND_BYTES + 10.0 * LEAST_BYTES), Clock())
    gate.opened_room(gate.owner("192.0.2.1"), "room")
    for _ in range(10):
        assert gate.may_record("192.0.2.1")
        gate.recorded("room", 900)
    gate.recorded("room", 900)
    assert not gate.may_record("192.0.2.1")


def test_a_whole_48_network_records_four_times_as_much_as_one_address() -> None:
    gate = AdmissionControl(Limits(recorded_per_address_per_day=1e6), Clock())
    for network in range(4):
        address = f"2001:db8:0:{network:x}::1"
        assert gate.may_record(address)
        gate.opened_room(gate.owner(address), f"room {network}")
        gate.recorded(f"room {network}", 950_000)
        assert not gate.may_record(address)
    assert gate.may_record("2001:db8:0:ffff::1")
    gate.opened_room(gate.owner("2001:db8:0:ffff::1"), "room")
    gate.recorded("room", 150_000)
    assert not gate.may_record("2001:db8:0:eeee::1") and gate.may_record("2001:db8:1::1")


def test_wrong_tokens_lock_the_guesser_for_a_minute_and_one_kind_only() -> None:
    clock = Clock()
    gate = control(clock, wrong_tokens_per_minute=3)
    assert [guesses(gate, "192.0.2.1", "seat") for _ in range(5)] == [False, False, False, True, True]
    assert not guesses(gate, "192.0.2.1", "admin")
    assert not guesses(gate, "192.0.2.2", "seat")
    clock.now = 61.0
    assert not guesses(gate, "192.0.2.1", "seat")


def test_many_addresses_free_only_the_oldest(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(admission, "MOST_KEPT", 50)
    gate = control(wrong_tokens_per_minute=1)
    for count in range(60):
        for _ in range(2):
            guesses(gate, f"192.0.2.{count}", "seat")
    assert guesses(gate, "192.0.2.59", "seat"), "still locked"
    assert not guesses(gate, "192.0.2.0", "seat"), "forgotten"


def test_who_is_still_there_is_not_forgotten_for_those_who_came_later(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(admission, "MOST_KEPT", 50)
    gate = control(rooms_per_address_per_minute=2)
    allowed = []
    for turn in range(3):
        allowed.append(gate.may_open_room("192.0.2.1"))
        for count in range(30):
            gate.may_open_room(f"198.51.{turn}.{count}")
    assert allowed == [True, True, False]


def test_a_48_network_has_four_times_what_a_64_network_has() -> None:
    gate = control(rooms_per_address_per_minute=2, sockets_per_address=2, connections_per_address=2)
    connections = ConnectionLimits(Limits(connections_per_address=2), ("2001:db8:1:7::7",), Clock())
    networks = [f"2001:db8:1:{number}::1" for number in range(12)]
    eight = [True] * 8 + [False] * 4
    assert [gate.may_open_room(each) for each in networks] == eight
    assert [gate.enter(each) == "" for each in networks] == eight
    assert [gate.begin_answer(each) for each in networks] == eight
    assert [connections.opened(each) for each in networks] == eight
    for elsewhere in ("2001:db8:2::1", "192.0.2.1", "192.0.2.1/64"):
        assert gate.may_open_room(elsewhere) and gate.enter(elsewhere) == "" and connections.opened(elsewhere)
    gate.leave(networks[0])
    gate.end_answer(networks[0])
    for each in networks[:5]:
        connections.closed(each)
    connections.opened("2001:db8:1:7::7")
    connections.closed("2001:db8:1:7::7")
    assert gate.enter(networks[-1]) == "" and gate.begin_answer(networks[-1])
    assert [connections.opened(networks[-1]) for _ in range(2)] == [True, False]


def test_connecting_again_and_again_has_to_wait() -> None:
    clock = Clock()
    gate = control(clock, connects_per_address_per_minute=60)
    for _ in range(60):
        assert gate.enter("192.0.2.1") == ""
        gate.joined("192.0.2.1")
        gate.leave("192.0.2.1")
    assert "wait" in gate.enter("192.0.2.1")
    assert gate.enter("192.0.2.2") == ""
    clock.now = 2.0
    assert gate.enter("192.0.2.1") == ""


def test_work_on_maps_of_an_address_uses_up_its_checks() -> None:
    gate = control(map_checks_per_minute=120)
    gate.worked_on_map("192.0.2.1", admission.MAP_WORK_S / 2)
    assert [gate.may_check_map("192.0.2.1") for _ in range(61)] == [True] * 60 + [False]
    gate.worked_on_map("192.0.2.2", 10 * admission.MAP_WORK_S)
    assert not gate.may_check_map("192.0.2.2") and gate.may_check_map("192.0.2.3")
