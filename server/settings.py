"""Everything that can be set about a server, in one frozen value; the command line is made into it."""

import argparse
import os
from dataclasses import dataclass, field
from pathlib import Path

from movingout.world.constants import TICK_SECONDS

MOST_WORKERS = 64
AGENT_WORKERS = min(2, os.cpu_count() or 1)
"""How many processes for agents the commands start: twenty seats of BASS that decide in the same tick keep one busy for
most of it."""


def worker_count(text: str) -> int:
    """A number of such processes from the command line."""
    if not text.isdecimal() or not 1 <= int(text) <= MOST_WORKERS:
        raise argparse.ArgumentTypeError(f"from 1 to {MOST_WORKERS} processes are possible, not {text}")
    return int(text)


@dataclass(frozen=True, slots=True)
class Limits:
    """What one server process takes on before it refuses, in a sentence."""

    rooms: int = 250
    sockets: int = 2000
    sockets_per_address: int = 200
    waiting_per_address: int = 32  # sockets that have not joined a room yet
    connections_per_address: int = 400  # TCP connections
    spectators_per_room: int = 30
    rooms_per_address_per_minute: int = 20
    cpu_share: float = 0.7  # of one core, averaged over 5 s; beyond it no room is opened
    join_s: float = 5.0  # a socket that has not joined by then is closed
    header_s: float = 10.0  # a request whose header is not complete by then is closed
    frame_bytes: int = 4096
    body_bytes: int = 16 * 1024
    # Two seats at one screen: 2 x 20 inputs, acknowledgements with them, a ping and control messages now and then.
    messages_per_s: float = 60.0
    message_burst: float = 60.0
    wrong_tokens_per_minute: int = 10  # by one address, then it has to wait


@dataclass(frozen=True, slots=True)
class Settings:
    """How one server runs. Times in seconds."""

    host: str = "127.0.0.1"
    port: int = 8000
    data: Path = Path("data")
    partner: str = "scripted"  # what the lobby proposes for the second seat
    tls: bool = False
    origins: tuple[str, ...] = ()  # further allowed origins, as https://play.example.org
    trusted_proxies: tuple[str, ...] = ()  # addresses whose X-Forwarded-For is believed
    agent_workers: int = 1
    countdown_s: float = 3.0  # from "everybody is ready" to the first tick
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
