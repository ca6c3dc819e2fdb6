"""Which process the next connections of an address go to."""

from typing import cast

from movingout.server.processes.expected_connections import CONNECTIONS, EXPECTED_S, MOST_EXPECTED, ExpectedConnections
from movingout.server.processes.room_link import RoomLink

ONE, OTHER = cast(RoomLink, "one"), cast(RoomLink, "other")


class Clock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


def test_connections_go_there_until_the_websocket_has_arrived() -> None:
    expected = ExpectedConnections(Clock())
    expected.add("1.2.3.4", ONE)
    assert expected.take("5.6.7.8") is None
    assert expected.take("1.2.3.4") is ONE
    expected.arrived("1.2.3.4", ONE)
    assert expected.take("1.2.3.4") is None


def test_a_few_connections_are_enough_and_a_moment_too() -> None:
    clock = Clock()
    expected = ExpectedConnections(clock)
    expected.add("1.2.3.4", ONE)
    assert [expected.take("1.2.3.4") for _ in range(CONNECTIONS + 1)] == [ONE] * CONNECTIONS + [None]
    expected.add("1.2.3.4", ONE)
    clock.now += EXPECTED_S
    assert expected.take("1.2.3.4") is None


def test_two_people_at_one_address_come_one_after_the_other() -> None:
    expected = ExpectedConnections(Clock())
    expected.add("1.2.3.4", ONE)
    expected.add("1.2.3.4", OTHER)
    assert expected.take("1.2.3.4") is ONE
    expected.arrived("1.2.3.4", ONE)
    assert expected.take("1.2.3.4") is OTHER
    expected.arrived("1.2.3.4", ONE)  # of a process that nobody is expected in any more
    assert expected.take("1.2.3.4") is OTHER


def test_one_address_is_expected_a_limited_number_of_times() -> None:
    expected = ExpectedConnections(Clock())
    for _ in range(10 * MOST_EXPECTED):
        expected.add("1.2.3.4", ONE)
    taken = 0
    while expected.take("1.2.3.4") is not None:
        taken += 1
    assert taken == MOST_EXPECTED * CONNECTIONS
