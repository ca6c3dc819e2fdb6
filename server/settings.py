"""The settings of a server as one frozen value. The command-line options are made from it."""

import argparse
import os
from dataclasses import dataclass, field
from pathlib import Path

from movingout.server.options import option
from movingout.world.constants import TICK_SECONDS

MOST_WORKERS = 64
# Default of the commands. Twenty BASS seats that decide in the same tick keep one process busy for most of it.
AGENT_WORKERS = min(2, os.cpu_count() or 1)
MOST_COUNTDOWN_S = 60.0
DATA = Path("data")


def worker_count(text: str) -> int:
    """A number of processes for agents."""
    if not text.isdecimal() or not 1 <= int(text) <= MOST_WORKERS:
        raise argparse.ArgumentTypeError(f"from 1 to {MOST_WORKERS} processes are possible, not {text}")
    return int(text)


def countdown(text: str) -> float:
    """The length of a countdown in seconds."""
    seconds = float(text)
    if not 0.0 <= seconds <= MOST_COUNTDOWN_S:
        raise argparse.ArgumentTypeError(f"from 0 to {MOST_COUNTDOWN_S:g} seconds are possible, not {text}")
    return seconds


@dataclass(frozen=True, slots=True)
class Limits:
    """What one server process accepts before it refuses."""

    rooms: int = option(250, "rooms at the same time (%(default)s)", flag="--max-rooms", metavar="N", parse=int)
    sockets: int = 2000
    sockets_per_address: int = option(
        200, "connections from one address (%(default)s)", flag="--max-sockets", metavar="N", parse=int
    )
    waiting_per_address: int = 32  # sockets that have not joined a room yet
    connections_per_address: int = 400  # TCP connections
    spectators_per_room: int = 30
    rooms_per_address_per_minute: int = 20
    open_rooms_per_address: int = 60  # a class behind one address
    unjoined_rooms_per_address: int = 10
    rooms_for_operator: int = 10  # of all, that only the operator may open
    connects_per_address_per_minute: int = 600
    study_arrivals_per_minute: int = 1000  # by one address: a whole class opens its links at once
    map_checks_per_minute: int = 120  # of drawn maps, by one address: the editor asks after each change
    map_solves_per_minute: int = 6  # by one address
    cpu_share: float = 0.7  # of one core, averaged over 5 s; above it no room is opened
    join_s: float = 5.0  # for a socket to join
    header_s: float = 10.0  # for a request to arrive
    frame_bytes: int = 4096
    body_bytes: int = 16 * 1024
    # Two seats at one screen: 2 x 20 inputs, acknowledgements with them, a ping and control messages now and then.
    messages_per_s: float = 60.0
    message_burst: float = 60.0
    wrong_tokens_per_minute: int = 10  # by one address, then it is locked for a while


@dataclass(frozen=True, slots=True)
class Settings:
    """How one server runs. Times in seconds."""

    host: str = option("127.0.0.1", "address to serve (%(default)s); 0.0.0.0 for all networks")
    port: int = option(8000, "port to serve (%(default)s); 0 for any free one", parse=int)
    partner: str = option("scripted", "the partner that the lobby proposes (%(default)s)", metavar="AGENT")
    data: Path = option(  # noqa: RUF009 (it makes a field)
        DATA, "the data folder (%(default)s)", metavar="DIR", parse=Path
    )
    tls: bool = option(
        False, "serve https with a self-signed certificate, which gamepads on other machines need", parse=None
    )
    origins: tuple[str, ...] = option(
        (), "also accept connections from pages of this origin (repeatable)", flag="--origin", metavar="URL"
    )
    trusted_proxies: tuple[str, ...] = option(
        (), "trust the X-Forwarded-For of this reverse proxy (repeatable)", flag="--proxy", metavar="ADDRESS"
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
    admin_token: str = ""  # made at start when empty
    lobby: bool = True  # whether anybody may open a room; a study opens its own
    tick_s: float = TICK_SECONDS  # real seconds per tick; less only to rehearse a study faster than people play
    limits: Limits = field(default_factory=Limits)

    @property
    def recordings(self) -> Path:
        return self.data / "recordings"

    @property
    def rooms(self) -> Path:
        return self.data / "rooms"

    @property
    def answers(self) -> Path:
        return self.data / "answers"
