"""What a node may believe of its leases while the database is silent."""

from movingout.server.cluster.held_leases import MARGIN_S, HeldLeases
from movingout.server.settings import LEASE_S


def held(shared: bool) -> HeldLeases:
    leases = HeldLeases()
    leases.shared = shared
    leases.taken("k", 7, asked_at=100.0)
    return leases


def test_a_lease_lasts_from_the_time_of_the_question_and_ends_before_others_may_take_it() -> None:
    leases = held(shared=True)
    end = 100.0 + LEASE_S - MARGIN_S
    assert leases.valid("k", end - 0.01) and not leases.valid("k", end)
    assert leases.renewed({"k"}, asked_at=103.0) == frozenset()
    assert leases.valid("k", end) and not leases.valid("k", 103.0 + LEASE_S)


def test_where_nobody_else_has_the_folder_rooms_go_on_without_the_database() -> None:
    assert held(shared=False).valid("k", 1e9)


def test_what_the_database_does_not_confirm_is_lost_even_without_others() -> None:
    leases = held(shared=False)
    leases.taken("m", 1, asked_at=100.0)
    assert leases.renewed({"m"}, asked_at=101.0) == {"k"}
    assert not leases.valid("k", 101.0) and leases.valid("m", 101.0)
    assert leases.fences == {"m": 1}


def test_a_shard_that_was_never_taken_is_not_valid() -> None:
    assert not held(shared=False).valid("z", 100.0)
