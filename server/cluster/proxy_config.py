"""The configuration of the proxy in front of a cluster, for HAProxy and Caddy, from templates."""

import argparse
import re
import shlex
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from movingout.server.api.request_limit import FILE_COST
from movingout.server.cluster.app import CHECK
from movingout.server.cluster.errors import ClusterError
from movingout.server.cluster.shards import SHARDS, STUDY
from movingout.server.settings import Limits, node_name

Proxy = Literal["haproxy", "caddy"]
TEMPLATES: Mapping[Proxy, str] = {"haproxy": "haproxy.cfg", "caddy": "Caddyfile"}

_ADDRESS = re.compile(r"(\[[0-9A-Fa-f:]+\]|[A-Za-z0-9.\-]+):(\d{1,5})")
_LISTENS = re.compile(r"(https?://)?([A-Za-z0-9.*\-]*|\[[0-9A-Fa-f:]+\]):(\d{1,5})")
_DOMAIN = re.compile(r"[A-Za-z0-9]([A-Za-z0-9.\-]{0,250}[A-Za-z0-9])?")
_PLAIN = re.compile(r"[A-Za-z0-9_./:*@\[\]\-]+")  # nothing that a configuration file would read otherwise


@dataclass(frozen=True)
class ProxyLimits:
    """What the proxy lets through; an address is an IPv4 address, or a /64 network of IPv6."""

    connections: int = 20_000  # in all
    per_address: int = Limits().connections_per_address
    new_per_10s: int = round(10 * Limits().accepts_per_address_per_s)
    requests_per_10s: int = round(10 * Limits().requests_per_address_per_s) + 1800

    @property
    def files_per_10s(self) -> int:
        """Requests of any kind."""
        return round(self.requests_per_10s / FILE_COST)

    @classmethod
    def for_address(cls, connections: int, per_address: int) -> "ProxyLimits":
        """For as many connections of one address; from the usual number on, the rest grows with them."""
        usual = cls()
        share = max(1.0, per_address / usual.per_address)
        return cls(connections, per_address, round(share * usual.new_per_10s), round(share * usual.requests_per_10s))


@dataclass(frozen=True)
class ProxyConfig:
    """`nodes` are their addresses, HOST:PORT, by name. Raises ClusterError for what cannot be written."""

    nodes: Mapping[str, str]
    domain: str = ""
    certificate: str = ""  # PEM file with key and chain; empty: plain http
    listen: str = ""
    redirect_from: str = ":80"
    admin_socket: str = ""
    resolve_names: bool = False  # also while HAProxy runs; Caddy always does
    limits: ProxyLimits = field(default_factory=ProxyLimits)
    command: str = ""

    def __post_init__(self) -> None:
        if not self.nodes:
            raise ClusterError("a proxy needs at least one node: --node NAME=HOST:PORT")
        if self.domain and not _DOMAIN.fullmatch(self.domain):
            raise ClusterError(f"{self.domain!r} is not the name of a site; it looks like game.example.org")
        for text in (self.certificate, self.listen, self.redirect_from, self.admin_socket):
            if text and not _PLAIN.fullmatch(text):
                raise ClusterError(f"{text!r} cannot stand in the configuration of a proxy: it has special characters")
        for text in (self.listen, self.redirect_from):
            found = _LISTENS.fullmatch(text)
            if text and (found is None or not 0 < int(found[3]) < 65536):
                raise ClusterError(f"{text!r} is nowhere to listen; it looks like :443 or 10.0.0.9:443")
        if len(self.nodes) > len(SHARDS):
            raise ClusterError(f"a cluster has up to {len(SHARDS)} nodes, not {len(self.nodes)}; make two clusters")

    def text(self, proxy: Proxy) -> str:
        """The whole file. Raises ClusterError."""
        if proxy == "haproxy" and "://" in self.listen + self.redirect_from:
            raise ClusterError("HAProxy listens at :443 or 10.0.0.9:443, without http://")
        self._refuse_without_effect(proxy)
        if proxy == "caddy" and self.domain and self.listen and not self.listen.startswith(":"):
            raise ClusterError(f"with --domain, Caddy takes a port alone, such as --listen :8443, not {self.listen}")
        folder = Path(__file__).parent / "templates"
        environment = Environment(
            loader=FileSystemLoader(folder), undefined=StrictUndefined, keep_trailing_newline=True, autoescape=False
        )
        environment.filters["bound"] = _bound
        listen = self.listen or (":443" if self.certificate else ":80")
        return environment.get_template(TEMPLATES[proxy]).render(
            command=self.command,
            nodes=self.nodes,
            domain=self.domain,
            site=self.domain + self.listen if self.domain else listen,
            certificate=self.certificate,
            listen=listen,
            redirect_from=self.redirect_from,
            redirects=self._redirects(listen),
            admin_socket=self.admin_socket,
            resolve_names=self.resolve_names,
            limits=self.limits,
            shards=SHARDS,
            study=STUDY,
            check=CHECK,
        )

    def _redirects(self, listen: str) -> list[str]:
        """HAProxy's rules that send http to https. Who names the port of http is sent to that of https."""
        if not self.certificate or not self.redirect_from:
            return []
        http, https = (int(address.rpartition(":")[2]) for address in (self.redirect_from, listen))
        usual = "scheme https code 301 unless { ssl_fc }"
        if (http, https) == (80, 443):
            return [usual]
        port = "" if https == 443 else f":{https}"
        to_port = f"location https://%[req.hdr(host),field(1,:)]{port}%[pathq] code 301 if !{{ ssl_fc }}"
        # At another port than 80 none is named where somebody else, such as a container, passes port 80 on.
        return [to_port] if http == 80 else [f"{to_port} {{ req.hdr(host) -m reg :[0-9]+$ }}", usual]

    def _refuse_without_effect(self, proxy: Proxy) -> None:
        """Raises ClusterError for what would do nothing."""
        redirects, limited = self.redirect_from != ProxyConfig.redirect_from, self.limits != ProxyLimits()
        if proxy == "caddy" and (redirects or limited or self.admin_socket):
            options = "--redirect-from, --admin-socket, --max-connections and --max-per-address"
            raise ClusterError(f"{options} are for HAProxy; Caddy has nothing of that kind")
        if redirects and self.redirect_from and not self.certificate:
            raise ClusterError("--redirect-from sends http to https, which needs --certificate")


def _bound(listen: str) -> list[str]:
    """For HAProxy, to which a port alone means IPv4 alone; one socket for both would pass on ::ffff:192.0.2.7."""
    return [listen, f"::{listen} v6only"] if listen.startswith(":") else [listen]


def nodes_of(texts: Sequence[str]) -> dict[str, str]:
    """Addresses by name, of `NAME=HOST:PORT` each. Raises ClusterError."""
    nodes: dict[str, str] = {}
    for text in texts:
        name, _, address = text.partition("=")
        found = _ADDRESS.fullmatch(address)
        if found is None or not 0 < int(found[2]) < 65536 or not _is_name(name):
            raise ClusterError(f"{text!r} is not a node; it looks like a=10.0.0.1:8000")
        if name in nodes or address in nodes.values():
            raise ClusterError(f"{text!r}: every node has a name and an address of its own")
        nodes[name] = address
    return nodes


def command_line() -> str:
    """How this program was called, for the head of the file, which is one line."""
    return shlex.join(["movingout", *sys.argv[1:]]).replace("\n", " ")


def _is_name(text: str) -> bool:
    try:
        return bool(node_name(text))
    except argparse.ArgumentTypeError:
        return False
