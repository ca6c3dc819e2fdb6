"""Limits on TCP connections: how many there are, and how many one address holds and opens. Proxies speak for others."""

import ipaddress
import math
from collections import Counter, defaultdict
from collections.abc import Callable, Collection

from movingout.server.connection.admission import address_group, used
from movingout.server.connection.networks import counted_as, take_from_all
from movingout.server.connection.token_bucket import TokenBucket
from movingout.server.settings import Limits

HANDSHAKE_COST = 2.5  # plain connections


class ConnectionLimits:
    """Counts all connections, and those of each address; a trusted proxy has no limit of its own.

    `most` there may be of all addresses together, with the `websockets`: those that were admitted are counted
    elsewhere, from then on until they are gone.
    """

    def __init__(
        self,
        limits: Limits,
        proxies: Collection[str],
        clock: Callable[[], float],
        refusals: Counter[str] | None = None,
        most: float = math.inf,
        websockets: Callable[[], int] = int,
    ) -> None:
        self._limits = limits
        self._proxies = proxies
        self._clock = clock
        self.most = most
        self._websockets = websockets
        self._total = 0
        self._open: defaultdict[str, int] = defaultdict(int)
        self._opened: dict[str, TokenBucket] = {}
        self._refusals = Counter() if refusals is None else refusals

    @property
    def any_open(self) -> bool:
        """Also of people who read: pages of a study keep one open to hear news."""
        return self._total + self._websockets() > 0

    def opened(self, address: str, tls: bool = False) -> bool:
        """Count a connection, which must be `closed`; False when it is one too many. `tls`: before its handshake."""
        self._total += 1
        fits = self._total + self._websockets() <= self.most
        allowed = (is_trusted(address, self._proxies) or self._within_limits(address_group(address), tls)) and fits
        self._refusals["connection"] += not allowed
        return allowed

    def _within_limits(self, group: str, tls: bool) -> bool:
        counted, most, now = counted_as(group), self._limits.connections_per_address, self._clock()
        for each, _ in counted:
            self._open[each] += 1
        per_s, cost = self._limits.accepts_per_address_per_s, HANDSHAKE_COST if tls else 1.0
        return all(self._open[each] <= times * most for each, times in counted) and take_from_all(
            group, cost, now, lambda each, times: used(self._opened, each, times * per_s, times * 10.0 * per_s, now)
        )

    def closed(self, address: str) -> None:
        self._total -= 1
        if is_trusted(address, self._proxies):
            return
        for group, _ in counted_as(address_group(address)):
            if group in self._open:
                self._open[group] -= 1
                if self._open[group] <= 0:
                    del self._open[group]


def is_trusted(address: str, proxies: Collection[str]) -> bool:
    """Whether this is the address of one of the proxies, which are addresses and networks."""
    if not proxies:
        return False
    if address in proxies:
        return True
    try:
        parsed = ipaddress.ip_address(address)
    except ValueError:
        return False
    return any(_within(parsed, proxy) for proxy in both_forms(proxies))


def both_forms(proxies: Collection[str]) -> list[str]:
    """The same proxies for a server that listens on `::`, too, which sees 192.0.2.1 as ::ffff:192.0.2.1."""
    return [*proxies, *(mapped for proxy in proxies if (mapped := _mapped(proxy)))]


def _mapped(proxy: str) -> str:
    """The form of an IPv4 address or network in IPv6; empty for others."""
    try:
        network = ipaddress.IPv4Network(proxy, strict=False)
    except ValueError:
        return ""
    mapped = f"::ffff:{network.network_address}"
    return f"{mapped}/{96 + network.prefixlen}" if "/" in proxy else mapped


def _within(address: ipaddress.IPv4Address | ipaddress.IPv6Address, network: str) -> bool:
    try:
        return address in ipaddress.ip_network(network, strict=False)
    except ValueError:
        return False
