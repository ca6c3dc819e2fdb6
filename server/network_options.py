"""Options that name addresses, as operators write them: what no request could match is refused before the start.

The readers raise ArgumentTypeError.
"""

import argparse
import ipaddress
import re
from collections.abc import Iterable
from urllib.parse import urlsplit

EVERYBODY = "*"
ALL_PROXIES = "nobody would have limits if everybody were a proxy; name its network, such as --proxy 10.0.0.0/8"
_MAPPED = ipaddress.IPv6Network("::ffff:0:0/96")  # all of IPv4, as a server that listens on `::` sees it
_NAME = re.compile(r"[A-Za-z0-9]([A-Za-z0-9._\-]{0,250}[A-Za-z0-9])?")


def served_address(text: str) -> str:
    """Where to listen. An empty one, as of an unset variable, would be all networks."""
    if not text.strip():
        raise argparse.ArgumentTypeError("write 127.0.0.1 (this machine only) or 0.0.0.0 (the network too)")
    return text


def is_loopback(host: str) -> bool:
    """Whether this is a name or an address of this machine alone."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost" or host.endswith(".localhost")


def proxy_address(text: str) -> str:
    """A trusted proxy. A name would match no connection, and all people would share one address and its limits.

    Where every address is trusted, the first in X-Forwarded-For counts, which is written by whoever sends the request.
    """
    try:
        network = None if text == EVERYBODY else ipaddress.ip_network(text)
    except ValueError:
        problem = f"a proxy is named by its address, such as 10.0.0.9 or 10.0.0.0/24, not {text!r}"
        raise argparse.ArgumentTypeError(problem) from None
    if network is None or trusts_everybody([text]):
        raise argparse.ArgumentTypeError(ALL_PROXIES)
    return text


def trusts_everybody(proxies: Iterable[str]) -> bool:
    """Whether these addresses and networks together hold all of IPv4, in its form in IPv6 or not, or all of IPv6."""
    networks = [ipaddress.ip_network(proxy, strict=False) for proxy in proxies]
    sixth = list(ipaddress.collapse_addresses(one for one in networks if isinstance(one, ipaddress.IPv6Network)))
    fourth = [one for one in networks if isinstance(one, ipaddress.IPv4Network)]
    fourth += [_unmapped(one) for one in sixth if one.subnet_of(_MAPPED)]
    all_of_fourth = any(one.prefixlen == 0 for one in ipaddress.collapse_addresses(fourth))
    return all_of_fourth or any(_MAPPED.subnet_of(one) for one in sixth)  # also all of IPv6, which holds it


def _unmapped(network: ipaddress.IPv6Network) -> ipaddress.IPv4Network:
    """The network of IPv4 whose form in IPv6 this is."""
    return ipaddress.IPv4Network((int(network.network_address) & 0xFFFFFFFF, network.prefixlen - 96))


def host_name(text: str) -> str:
    """The name of a site as requests have it: without https://, port and final dot, in small letters."""
    name = text.rstrip(".").lower()
    if not _NAME.fullmatch(name):
        problem = f"a name looks like study.example.org, without https:// and without a port, not {text!r}"
        raise argparse.ArgumentTypeError(problem)
    return name


def page_origin(text: str) -> str:
    """The origin of other pages as browsers send it: scheme, host and port, and nothing behind them."""
    try:
        parts = urlsplit(text)
        is_origin = parts.scheme in ("http", "https") and bool(parts.hostname) and parts.port != 0
    except ValueError:
        is_origin = False
    if not is_origin or parts.path.strip("/") or parts.query or parts.fragment or "@" in parts.netloc:
        problem = f"an origin looks like https://study.example.org or http://localhost:5173, not {text!r}"
        raise argparse.ArgumentTypeError(problem)
    return f"{parts.scheme}://{parts.netloc}".lower()
