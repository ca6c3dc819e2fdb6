"""`movingout play`: serve the game and print its links."""

import argparse
import logging
import sys
from dataclasses import replace

from movingout.agents.catalogue import agent_card
from movingout.recordings.recorded_seat import GHOST, is_ghost
from movingout.server.app import create_app
from movingout.server.host import Host
from movingout.server.open_files import raise_open_files
from movingout.server.options import add_options, values_of
from movingout.server.own_maps.folder import map_files
from movingout.server.persistence.data_folder import (
    BadDataFolder,
    exclusive_data_folder,
    refuse_study_folder,
    told_interrupted,
)
from movingout.server.rooms.ghost_partner import ghost_seat
from movingout.server.security.admin_token import NAME, kept_token
from movingout.server.security.certificate import Certificate, certificate_in, lan_addresses
from movingout.server.settings import Limits, Settings
from movingout.server.uvicorn_server import game_server, listen
from movingout.world.exactness import inexact_engine

EVERYWHERE = ("0.0.0.0", "::")


def configure(parser: argparse.ArgumentParser) -> None:
    add_options(parser, Settings)
    add_options(parser, Limits)


def run(args: argparse.Namespace) -> int:
    settings = _settings(args)
    agent_card(settings.partner)
    if is_ghost(settings.partner):
        ghost_seat(settings.partner.removeprefix(f"{GHOST}:"))
    if settings.maps is not None:
        map_files(settings.maps)
    refuse_study_folder(settings.data)
    if caution := inexact_engine():
        print(f"movingout: {caution}", file=sys.stderr)
    if caution := raise_open_files(settings.limits):
        print(f"movingout: {caution}", file=sys.stderr)
    with exclusive_data_folder(settings.data):
        listening = listen(settings.host, settings.port)
        settings = replace(with_kept_token(settings), port=listening.getsockname()[1])
        certificate = certificate_for(settings) if settings.tls else None
        logging.basicConfig(level=logging.WARNING, format="%(levelname)s %(name)s: %(message)s", stream=sys.stderr)
        app = create_app(settings)
        links = _links(settings, app.state.host)
        for problem in app.state.host.own_maps.problems.values():
            print(f"movingout: own map left out: {problem}", file=sys.stderr)
        server = game_server(app, settings, certificate, on_ready=lambda: print(links, flush=True))
        server.run([listening])
    if told := told_interrupted(settings.data):
        print(told)
    return 0 if server.started else 1


def _settings(args: argparse.Namespace) -> Settings:
    """More sockets per address also raise the limits on waiting sockets and connections per address."""
    given = Limits(**values_of(args, Limits))
    limits = replace(
        given,
        waiting_per_address=max(given.waiting_per_address, given.sockets_per_address),
        connections_per_address=max(given.connections_per_address, 2 * given.sockets_per_address),
        connects_per_address_per_minute=max(given.connects_per_address_per_minute, 10 * given.sockets_per_address),
    )
    return Settings(**values_of(args, Settings), limits=limits)


def certificate_for(settings: Settings) -> Certificate:
    """The certificate, created at the first start. Raises BadDataFolder."""
    try:
        return certificate_in(settings.data / "tls", settings.host)
    except OSError as error:
        raise BadDataFolder(f"cannot keep the certificate in {settings.data / 'tls'} ({error.strerror})") from None


def with_kept_token(settings: Settings) -> Settings:
    """The settings with the admin token of the data folder. Raises BadDataFolder."""
    try:
        return replace(settings, admin_token=kept_token(settings.data))
    except OSError as error:
        raise BadDataFolder(f"cannot keep the admin token in {settings.data / NAME} ({error.strerror})") from None


def _links(settings: Settings, host: Host) -> str:
    """The links to print at the start."""
    bases = addresses(settings)
    lines = ["", "Moving Out Live is ready.", ""]
    lines += [f"  Play         {base}/" for base in bases]
    lines += [f"  Watch        {bases[0]}/watch/ROOM (every room shows its own link)"]
    lines += [f"  Recordings   {bases[0]}/recordings"]
    lines += [f"  Admin        {bases[0]}/admin", f"  Admin token  {host.admin_token}"]
    if settings.maps is not None:
        lines += [f"  Your maps    {len(host.own_maps.maps)} in the lobby, from {settings.maps.resolve()}"]
    lines += [f"  Data         {settings.data.resolve()}", ""]
    return "\n".join(lines + hints(settings, "movingout play"))


def addresses(settings: Settings) -> list[str]:
    """The server's addresses, this machine's own first."""
    scheme = "https" if settings.tls else "http"
    hosts = ["localhost", *lan_addresses()] if settings.host in EVERYWHERE else [settings.host]
    return [f"{scheme}://{_bracketed(host)}:{settings.port}" for host in hosts]


def hints(settings: Settings, command: str) -> list[str]:
    """Hints to print after the links."""
    everywhere = settings.host in EVERYWHERE
    if not everywhere and not settings.tls:
        return [f"Only this machine can connect. For others in the network: {command} --host 0.0.0.0 --tls", ""]
    if everywhere and not settings.tls:
        return ["On other machines gamepads need https: add --tls.", ""]
    return ["The certificate is self-signed: the browser asks once whether to trust it.", ""]


def _bracketed(host: str) -> str:
    return f"[{host}]" if ":" in host else host
