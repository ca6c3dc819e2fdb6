"""Networks of IPv6: a free tunnel is a whole /48, which has each limit four times, not once for each of 65,536 /64s."""

import ipaddress
from collections.abc import Callable
from functools import lru_cache

from movingout.server.connection.token_bucket import TokenBucket

WIDE = 48
TIMES = 4  # of each limit that all of such a network have together


@lru_cache(10_000)
def counted_as(group: str) -> tuple[tuple[str, int], ...]:
    """Whom a group of addresses (`admission.address_group`) counts as, and how many times a limit each of them has."""
    if group.endswith("/64"):
        try:
            return (group, 1), (str(ipaddress.IPv6Network(group).supernet(new_prefix=WIDE)), TIMES)
        except ValueError:  # what a proxy says need not be an address
            pass
    return ((group, 1),)


def take_from_all(group: str, cost: float, now: float, bucket_of: Callable[[str, int], TokenBucket]) -> bool:
    """Take from each bucket of what a group counts as, which `bucket_of` gives; from none where one has too little."""
    buckets = [bucket_of(*each) for each in counted_as(group)]
    return all([bucket.holds(now, cost) for bucket in buckets]) and all([bucket.take(now, cost) for bucket in buckets])
