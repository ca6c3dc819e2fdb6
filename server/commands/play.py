"""`movingout play`: serve the game and print its links."""

import argparse
import logging
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

from movingout.agents.catalogue import agent_card
from movingout.maps.errors import MovingOutError
from movingout.recordings.recorded_seat import GHOST, is_ghost
from movingout.server.app import create_app
from movingout.server.rooms.ghost_partner import ghost_seat
from movingout.server.security.admin_token import NAME, kept_token
from movingout.server.security.certificate import Certificate, certificate_in, lan_addresses
from movingout.server.settings import AGENT_WORKERS, Settings, worker_count
from movingout.server.uvicorn_server import game_server, listen
from movingout.world.exactness import inexact_engine

DEFAULTS = Settings()
EVERYWHERE = ("0.0.0.0", "::")
MOST_COUNTDOWN_S = 60.0


class BadDataFolder(MovingOutError):
    """The data folder cannot be used."""


def configure(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("--host", default=DEFAULTS.host, help="address to serve (%(default)s); 0.0.0.0 for the whole network")
    add("--port", type=int, default=DEFAULTS.port, help="port to serve (%(default)s); 0 for any free one")
    add("--partner", default=DEFAULTS.partner, metavar="AGENT", help="agent that the lobby proposes (%(default)s)")
    add("--data", type=Path, default=DEFAULTS.data, metavar="DIR", help="where recordings and answers go (%(default)s)")
    add("--tls", action="store_true", help="serve https with a self-signed certificate, for gamepads in the network")
    add("--origin", action="append", default=[], metavar="URL", help="another page that may connect (repeatable)")
    add("--proxy", action="append", default=[], metavar="ADDRESS", help="a reverse proxy to believe (repeatable)")
    add(
        "--countdown", type=_seconds, default=DEFAULTS.countdown_s, metavar="S",
        help="seconds from \"everybody is ready\" to the first tick (%(default)s)",
    )  # fmt: skip
    add(
        "--agent-workers", type=worker_count, default=AGENT_WORKERS, metavar="N",
        help="processes for agents (%(default)s)",
    )  # fmt: skip
    add("--max-rooms", type=int, default=DEFAULTS.limits.rooms, metavar="N", help="rooms at the same time")
    add(
        "--max-sockets", type=int, default=DEFAULTS.limits.sockets_per_address, metavar="N",
        help="connections from one address (%(default)s)",
    )  # fmt: skip


def run(args: argparse.Namespace) -> int:
    settings = _settings(args)
    agent_card(settings.partner)
    if is_ghost(settings.partner):
        ghost_seat(settings.partner.removeprefix(f"{GHOST}:"))
    check_data(settings.data)
    if caution := inexact_engine():
        print(f"movingout: {caution}", file=sys.stderr)
    listening = listen(settings.host, settings.port)
    settings = replace(with_kept_token(settings), port=listening.getsockname()[1])
    certificate = certificate_for(settings) if settings.tls else None
    logging.basicConfig(level=logging.WARNING, format="%(levelname)s %(name)s: %(message)s", stream=sys.stderr)
    app = create_app(settings)
    links = _links(settings, app.state.host.admin_token)
    server = game_server(app, settings, certificate, on_ready=lambda: print(links, flush=True))
    server.run([listening])
    return 0 if server.started else 1


def _settings(args: argparse.Namespace) -> Settings:
    limits = replace(
        DEFAULTS.limits,
        rooms=args.max_rooms,
        sockets_per_address=args.max_sockets,
        waiting_per_address=max(DEFAULTS.limits.waiting_per_address, args.max_sockets),
        connections_per_address=max(DEFAULTS.limits.connections_per_address, 2 * args.max_sockets),
    )
    return Settings(
        host=args.host,
        port=args.port,
        data=args.data,
        partner=args.partner,
        tls=args.tls,
        origins=tuple(args.origin),
        trusted_proxies=tuple(args.proxy),
        agent_workers=args.agent_workers,
        countdown_s=args.countdown,
        limits=limits,
    )


def _seconds(text: str) -> float:
    seconds = float(text)
    if not 0.0 <= seconds <= MOST_COUNTDOWN_S:
        raise argparse.ArgumentTypeError(f"from 0 to {MOST_COUNTDOWN_S:g} seconds are possible, not {text}")
    return seconds


def check_data(folder: Path) -> None:
    """Make the folder and write a byte, so that a fault is told now and not after the first game."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder) as probe:
            probe.write(b"x")
            probe.flush()
    except OSError as error:
        raise BadDataFolder(
            f"cannot write to the data folder {folder} ({error.strerror}); choose another one: --data DIR"
        ) from None


def certificate_for(settings: Settings) -> Certificate:
    """Made at the first start. Raises BadDataFolder."""
    try:
        return certificate_in(settings.data / "tls", settings.host)
    except OSError as error:
        raise BadDataFolder(f"cannot keep the certificate in {settings.data / 'tls'} ({error.strerror})") from None


def with_kept_token(settings: Settings) -> Settings:
    """With the admin token of the data folder. Raises BadDataFolder."""
    try:
        return replace(settings, admin_token=kept_token(settings.data))
    except OSError as error:
        raise BadDataFolder(f"cannot keep the admin token in {settings.data / NAME} ({error.strerror})") from None


def _links(settings: Settings, admin_token: str) -> str:
    """What to open, for the person who has just started the server."""
    bases = addresses(settings)
    lines = ["", "Moving Out Live is ready.", ""]
    lines += [f"  Play         {base}/" for base in bases]
    lines += [f"  Watch        {bases[0]}/watch/ROOM (every room shows its own link)"]
    lines += [f"  Recordings   {bases[0]}/recordings"]
    lines += [f"  Admin        {bases[0]}/admin", f"  Admin token  {admin_token}"]
    lines += [f"  Data         {settings.data.resolve()}", ""]
    return "\n".join(lines + hints(settings, "movingout play"))


def addresses(settings: Settings) -> list[str]:
    """Where the server is found, this machine's own name first."""
    scheme = "https" if settings.tls else "http"
    hosts = ["localhost", *lan_addresses()] if settings.host in EVERYWHERE else [settings.host]
    return [f"{scheme}://{_bracketed(host)}:{settings.port}" for host in hosts]


def hints(settings: Settings, command: str) -> list[str]:
    """What else whoever started it may want to know."""
    everywhere = settings.host in EVERYWHERE
    if not everywhere and not settings.tls:
        return [f"Only this machine can connect. For others in the network: {command} --host 0.0.0.0 --tls", ""]
    if everywhere and not settings.tls:
        return ["On other machines gamepads need https: add --tls.", ""]
    return ["The certificate is self-signed: the browser asks once whether to trust it.", ""]


def _bracketed(host: str) -> str:
    return f"[{host}]" if ":" in host else host
