"""The settings of a server as one frozen value. The command-line options are made from it.

The readers raise ArgumentTypeError.
"""

import argparse
import os
import re
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import urlsplit

from movingout.agents.worker.thread_budget import MOST_CORES
from movingout.maps.commands.parser import filled, folder
from movingout.maps.errors import MovingOutError
from movingout.server.network_options import (
    ALL_PROXIES,
    host_name,
    is_loopback,
    page_origin,
    proxy_address,
    served_address,
    trusts_everybody,
)
from movingout.server.options import option
from movingout.server.processes.message_sockets import has_message_sockets
from movingout.world.constants import TICK_SECONDS

MOST_WORKERS = 64
LEAST_CORES = 0.05  # with 0, every worker was ended at once, again and again
# Default of the commands. Twenty BASS seats that decide in the same tick keep one process busy for most of it.
AGENT_WORKERS = min(2, os.cpu_count() or 1)
MOST_COUNTDOWN_S = 60.0
MOST_AT_ONCE = 1_000_000
LEASE_S = 5.0  # of the rooms of a node
MOST_PROCESSES = 32  # the last letter of a room's id says which one
SEVERAL_PROCESSES = has_message_sockets()
PROCESSES = max(1, min(MOST_PROCESSES, (os.cpu_count() or 1) - 1)) if SEVERAL_PROCESSES else 1  # of the commands
PARTNER = "bass@any"  # without a choice of the operator's
DATA = Path("data")
NODES = "nodes"


def worker_count(text: str) -> int:
    """A number of processes for agents."""
    if not text.isdecimal() or not 1 <= int(text) <= MOST_WORKERS:
        raise argparse.ArgumentTypeError(f"from 1 to {MOST_WORKERS} processes are possible, not {text}")
    return int(text)


def process_count(text: str) -> int:
    """A number of processes for rooms."""
    if not SEVERAL_PROCESSES and text != "1":
        raise argparse.ArgumentTypeError(
            f"only 1 is possible, not {text}: this system lacks the sockets over which processes hand on connections "
            "(AF_UNIX with SOCK_SEQPACKET); Linux has them"
        )
    if not text.isdecimal() or not 1 <= int(text) <= MOST_PROCESSES:
        raise argparse.ArgumentTypeError(f"from 1 to {MOST_PROCESSES} processes are possible, not {text}")
    return int(text)


def at_once(text: str) -> int:
    """How many of something a server takes at the same time."""
    if not text.isdecimal() or not 1 <= int(text) <= MOST_AT_ONCE:
        raise argparse.ArgumentTypeError(f"a whole number from 1 to {MOST_AT_ONCE:,} is possible, not {text}")
    return int(text)


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number") from None


def cores(text: str) -> float:
    """A number of cores, or a share of one."""
    number = _number(text)
    if not LEAST_CORES <= number <= MOST_WORKERS:
        raise argparse.ArgumentTypeError(f"from {LEAST_CORES:g} to {MOST_WORKERS} cores are possible, not {text}")
    return number


def countdown(text: str) -> float:
    """The length of a countdown in seconds."""
    seconds = _number(text)
    if not 0.0 <= seconds <= MOST_COUNTDOWN_S:
        raise argparse.ArgumentTypeError(f"from 0 to {MOST_COUNTDOWN_S:g} seconds are possible, not {text}")
    return seconds


def port(text: str) -> int:
    """The number of a TCP port."""
    if not text.isdecimal() or not 0 <= int(text) <= 65535:
        raise argparse.ArgumentTypeError(f"a port is a number from 0 to 65535, not {text}")
    return int(text)


def log_form(text: str) -> str:
    """How the log is written."""
    if text not in ("text", "json"):
        raise argparse.ArgumentTypeError(f"the log is written as text or json, not {text}")
    return text


def lease(text: str) -> float:
    """The length of a lease in seconds."""
    seconds = _number(text)
    if not 3.0 <= seconds <= 120.0:
        raise argparse.ArgumentTypeError(f"from 3 to 120 seconds are possible, not {text}")
    return seconds


def node_name(text: str) -> str:
    """The name of a node of a cluster: it is part of the names of files and of the proxy's configuration."""
    if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9-]{0,30}", text):
        raise argparse.ArgumentTypeError(f"a name has up to 31 letters, digits and '-', not {text!r}")
    return text


class WrongSettings(MovingOutError):
    """Options that do not go together."""


@dataclass(frozen=True, slots=True)
class Limits:
    """What one process with rooms accepts before it refuses."""

    rooms: int = option(
        250, "rooms at the same time per process (%(default)s)", flag="--max-rooms", metavar="N", parse=at_once
    )
    sockets: int = 2000
    sockets_per_address: int = option(
        200, "connections from one address (%(default)s)", flag="--max-sockets", metavar="N", parse=at_once
    )
    waiting_per_address: int = 32  # sockets that have not joined a room yet
    connections_per_address: int = 400  # TCP connections
    rooms_per_address_per_minute: int = 20
    open_rooms_per_address: int = 60  # a class behind one address
    unjoined_rooms_per_address: int = 10
    rooms_for_operator: int = 10  # of all, that only the operator may open
    connects_per_address_per_minute: int = 600
    accepts_per_address_per_s: float = 100.0  # TCP connections, in bursts of ten times as many
    requests_per_address_per_s: float = 60.0  # HTTP, in bursts of 30 times as many: a class opens the page at once
    recorded_per_address_per_day: float = 20e9  # bytes, about 170 hours of rooms
    answered_per_address_per_day: float = 1e9  # bytes of requests that answer questions; a class needs some 20 MB
    study_arrivals_per_minute: int = 1000  # by one address: a whole class opens its links at once
    study_consents_per_day: int = 2000  # by one address: whoever has agreed stays in the database, also without data
    study_changes_per_s: float = 2.0  # steps done, languages, stops of one participant, in bursts of ten times as many
    study_answers_per_s: float = 5.0  # of one participant, in bursts of ten times as many: each is written to the disk
    study_unknown_tokens_per_s: float = 20.0  # by one address, in bursts of a hundred times as many: after a restart
    map_checks_per_minute: int = 120  # of drawn maps, by one address: the editor asks after each change
    map_solves_per_minute: int = 6  # by one address
    tick_share: float = 0.5  # of one core that ticks take, averaged over 5 s; above it no room is opened
    late_share: float = 0.1  # of ticks that begin more than 50 ms late; above it no room is opened
    join_s: float = 5.0  # for a socket to join
    header_s: float = 10.0  # for a request to arrive
    unread_s: float = 30.0  # in which a part of an answer must be taken: 1 KB/s on average
    frame_bytes: int = 4096
    body_bytes: int = 16 * 1024
    # Two seats at one screen: 2 x 20 inputs, acknowledgements with them, a ping and control messages now and then.
    messages_per_s: float = 60.0
    message_burst: float = 60.0
    watcher_messages_per_s: float = 10.0  # of somebody without a seat, whose page says little
    wrong_tokens_per_minute: int = 10  # by one address, then it is locked for a while


@dataclass(frozen=True, slots=True)
class Settings:
    """How one server runs. Times in seconds."""

    host: str = option("127.0.0.1", "address to serve (%(default)s); 0.0.0.0 for all networks", parse=served_address)
    port: int = option(8000, "port to serve (%(default)s); 0 for any free one", parse=port)
    partner: str = option(
        PARTNER, "the partner that the lobby proposes (%(default)s)", metavar="AGENT", parse=str.strip
    )
    data: Path = option(  # noqa: RUF009 (it makes a field)
        DATA, "the data folder (%(default)s)", metavar="DIR", parse=folder
    )
    tls: bool = option(
        False, "serve https with a self-signed certificate, which gamepads on other machines need", parse=None
    )
    origins: tuple[str, ...] = option(
        (),
        "also accept connections from pages of this origin (repeatable)",
        flag="--origin",
        metavar="URL",
        parse=page_origin,
    )
    allowed_hosts: tuple[str, ...] = option(
        (), "the name that people reach the server under, if it is not this machine's own (repeatable)",
        flag="--allow-host", metavar="NAME", parse=host_name,
    )  # fmt: skip
    trusted_proxies: tuple[str, ...] = option(
        (),
        "trust the X-Forwarded-For of this reverse proxy (repeatable)",
        flag="--proxy",
        metavar="ADDRESS",
        parse=proxy_address,
    )
    maps: Path | None = option(  # noqa: RUF009 (it makes a field)
        None, "also offer the map files of this folder in the lobby", metavar="DIR", parse=Path
    )
    countdown_s: float = option(
        3.0, 'seconds from "both are ready" to the first tick (%(default)s)', flag="--countdown", metavar="S",
        parse=countdown,
    )  # fmt: skip
    agent_workers: int = option(
        1, "agent processes (%(default)s)", metavar="N", parse=worker_count, offered=AGENT_WORKERS
    )
    agent_thread_cores: float = option(
        MOST_CORES, "cores that agents' own threads may take in one agent process (%(default)s)",
        flag="--agent-threads", metavar="CORES", parse=cores,
    )  # fmt: skip
    slow_agents: bool = option(
        False, "let agents play that take longer for a decision than a tick: they miss ticks", parse=None
    )
    processes: int = option(
        1, "processes for rooms (%(default)s here: one per core but one)", metavar="N", parse=process_count,
        offered=PROCESSES,
    )  # fmt: skip
    cluster: str = option(
        "", "be a node of the cluster in this PostgreSQL database (docs/deploy.md)", metavar="URL",
        parse=filled,
    )  # fmt: skip
    node: str = option("", "the name of this node", metavar="NAME", parse=node_name)
    lease_s: float = option(
        LEASE_S, "seconds of silence after which other nodes take over this one's rooms (%(default)s)", flag="--lease",
        metavar="S", parse=lease,
    )  # fmt: skip
    s3: str = option(
        "", "also send finished recordings to this bucket, s3://BUCKET/FOLDER (docs/deploy.md)", metavar="URL",
        parse=filled,
    )  # fmt: skip
    log_format: str = option("text", "form of the log: text or json (%(default)s)", metavar="FORM", parse=log_form)
    admin_token: str = ""  # made at start when empty
    study: str = ""  # the id of the study that is served
    lobby: bool = True  # whether anybody may open a room; a study opens its own
    tick_s: float = TICK_SECONDS  # real seconds per tick; less only to rehearse a study faster than people play
    limits: Limits = field(default_factory=Limits)

    def __post_init__(self) -> None:
        """Raises WrongSettings where options that are possible one by one are not together."""
        if trusts_everybody(self.trusted_proxies):
            raise WrongSettings(f"--proxy {' --proxy '.join(self.trusted_proxies)}: {ALL_PROXIES}")

    @property
    def private(self) -> bool:
        """Whether only programs of this machine reach the server: then nobody who comes is a stranger."""
        here = self.host in ("127.0.0.1", "::1", "localhost")
        return here and not self.trusted_proxies and not self.has_public_name

    @property
    def has_public_name(self) -> bool:
        """Whether people elsewhere have a name for the server: where it is on loopback, that of a proxy before it."""
        origins = (urlsplit(origin).hostname or "" for origin in self.origins)
        return not all(is_loopback(name) for name in (*self.allowed_hosts, *origins))

    @property
    def in_cluster(self) -> bool:
        """Whether this is meant to be a node of a cluster, also where something that a node needs is missing."""
        return bool(self.cluster or self.node) or self.lease_s != LEASE_S

    @property
    def recordings(self) -> Path:
        return self.data / "recordings"

    @property
    def rooms(self) -> Path:
        return self.data / "rooms"

    @property
    def node_folder(self) -> Path:
        """What belongs to one node of a cluster alone."""
        return self.data / NODES / self.node

    @property
    def answers(self) -> Path:
        return self.data / "answers"
