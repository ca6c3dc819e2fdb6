"""`movingout play`: serve the game and print its links."""

import argparse
import os
import sys
from dataclasses import replace

from fastapi import FastAPI

from movingout.agents.live_options import check_live_agent
from movingout.maps.commands.map_cautions import hints_on
from movingout.maps.commands.sentences import tell
from movingout.server.app import create_app
from movingout.server.cluster.errors import ClusterError
from movingout.server.commands.partner_check import check_partner
from movingout.server.monitoring.logs import log_to
from movingout.server.network_options import is_loopback
from movingout.server.open_files import raise_open_files
from movingout.server.options import add_options, values_of
from movingout.server.own_maps.folder import MapFolder, map_files
from movingout.server.persistence.data_folder import (
    BadDataFolder,
    exclusive_data_folder,
    refuse_cluster_folder,
    refuse_served_folder,
    refuse_study_folder,
    told_interrupted,
)
from movingout.server.persistence.recording_uploads import check_bucket
from movingout.server.processes.front import Front
from movingout.server.processes.front_server import create_front_app, front_server
from movingout.server.public_host import PublicHost
from movingout.server.security.admin_token import NAME, kept_token
from movingout.server.security.certificate import Certificate, certificate_in, lan_addresses
from movingout.server.settings import PROCESSES, Limits, Settings
from movingout.server.uvicorn_server import game_server, listen
from movingout.world.exactness import inexact_engine

EVERYWHERE = ("0.0.0.0", "::")


def configure(parser: argparse.ArgumentParser) -> None:
    add_options(parser, Settings)
    add_options(parser, Limits)


def run(args: argparse.Namespace) -> int:
    settings = _settings(args)
    check_live_agent(settings.partner)
    if settings.maps is not None:
        map_files(settings.maps)
    if caution := check_partner(settings.partner, settings.maps):
        tell(caution)
    refuse_study_folder(settings.data)
    (refuse_served_folder if settings.cluster else refuse_cluster_folder)(settings.data)
    os.umask(0o077)  # what people do and say is for whoever runs the server
    if settings.s3:
        check_bucket(settings.s3, settings.data)
    tell_cautions(settings)
    with (
        exclusive_data_folder(settings.node_folder if settings.cluster else settings.data) as lock,
        listen(settings.host, settings.port) as listening,
    ):
        settings = replace(with_kept_token(settings), port=listening.getsockname()[1])
        certificate = certificate_for(settings) if settings.tls else None
        log_to(form="json" if settings.log_format == "json" else "text")
        app = app_for(settings, lock, certificate)
        links = _links(settings, app.state.host)
        tell_own_maps(app.state.host.own_maps)
        serve = game_server if settings.processes == 1 else front_server
        server = serve(app, settings, certificate, on_ready=lambda: print(links, flush=True))
        server.run([listening])
    if told := told_interrupted(settings.data) if not settings.cluster else "":
        print(told)
    return 0 if server.started else 1


def tell_cautions(settings: Settings) -> None:
    """Say on standard error what works, but not as well as it should: the physics engine, the limit of open files."""
    for caution in (inexact_engine(), raise_open_files(settings.limits)):
        if caution:
            tell(caution)


def tell_own_maps(own: MapFolder) -> None:
    """Say on standard error which of the operator's maps are left out, and what others probably mean otherwise."""
    hints = [f"own map {name}: {hint}" for name, spec in own.maps.items() for hint in hints_on(spec)]
    empty = own.folder is not None and not own.maps and not own.problems
    none = [f"there is no map file in {own.folder} yet"] if empty else []
    for sentence in (*none, *(f"own map left out: {problem}" for problem in own.problems.values()), *hints):
        tell(sentence)


def app_for(settings: Settings, lock: int, certificate: Certificate | None) -> FastAPI:
    """The server in this process, a node of a cluster, or the front of several. Raises FolderError, ClusterError."""
    if settings.cluster:
        from movingout.server.cluster.app import create_cluster_app  # what a cluster needs comes with an extra

        return create_cluster_app(settings)
    if settings.processes == 1:
        return create_app(settings)
    return create_front_app(Front(settings, settings.processes, lock, certificate))


def _settings(args: argparse.Namespace) -> Settings:
    """More sockets per address also raise the other limits of an address: on waiting sockets, connections, requests."""
    given = Limits(**values_of(args, Limits))
    limits = replace(
        given,
        waiting_per_address=max(given.waiting_per_address, given.sockets_per_address),
        connections_per_address=max(given.connections_per_address, 2 * given.sockets_per_address),
        accepts_per_address_per_s=max(given.accepts_per_address_per_s, 0.5 * given.sockets_per_address),
        requests_per_address_per_s=max(given.requests_per_address_per_s, 0.3 * given.sockets_per_address),
        connects_per_address_per_minute=max(given.connects_per_address_per_minute, 10 * given.sockets_per_address),
    )
    settings = Settings(**values_of(args, Settings), limits=limits)
    return as_node(settings) if settings.in_cluster else settings


def as_node(settings: Settings) -> Settings:
    """The settings of a node of a cluster, which has one process with rooms. Raises ClusterError."""
    if not settings.cluster or not settings.node:
        raise ClusterError("a node of a cluster needs both: --cluster postgresql://user@host/name and --node NAME")
    if settings.processes not in (1, PROCESSES):
        raise ClusterError("a node of a cluster has one process: start one node per core, each with its own --node")
    if settings.tls:
        raise ClusterError("a node of a cluster speaks http: the proxy in front has the certificate; leave --tls out")
    return replace(settings, processes=1)


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


def _links(settings: Settings, host: PublicHost) -> str:
    """The links to print at the start."""
    bases = addresses(settings)
    lines = ["", "Moving Out Live is ready.", ""]
    lines += [f"  Play         {base}/" for base in bases]
    lines += [f"  Watch        {bases[0]}/watch/ROOM (every room shows its own link)"]
    lines += [f"  Recordings   {bases[0]}/recordings"]
    lines += [f"  Admin        {bases[0]}/admin", f"  Admin token  {shown_token(settings, host.admin_token)}"]
    if settings.maps is not None:
        lines += [f"  Your maps    {len(host.own_maps.maps)} in the lobby, from {settings.maps.resolve()}"]
    lines += [f"  Data         {settings.data.resolve()}", ""]
    return "\n".join(lines + hints(settings, "movingout play"))


def shown_token(settings: Settings, token: str) -> str:
    """The admin token for people at a terminal; for a log file, where it is kept."""
    return token if sys.stdout.isatty() else f"in {(settings.data / NAME).resolve()}"


def addresses(settings: Settings) -> list[str]:
    """The server's addresses, this machine's own first."""
    scheme = "https" if settings.tls else "http"
    hosts = ["localhost", *lan_addresses()] if settings.host in EVERYWHERE else [settings.host]
    return [f"{scheme}://{_bracketed(host)}:{settings.port}" for host in hosts]


def hints(settings: Settings, command: str) -> list[str]:
    """Hints to print after the links."""
    if settings.trusted_proxies:
        return ["These addresses lie behind the proxy; give people the proxy's.", ""]
    if is_loopback(settings.host) and settings.has_public_name:
        proxy = "::1" if ":" in settings.host else "127.0.0.1"
        say = "Only this machine can connect. Name its reverse proxy, or everybody shares the limits of one address"
        return [f"{say}: {command} --proxy {proxy}", ""]
    if is_loopback(settings.host) and not settings.tls:
        return [f"Only this machine can connect. For others in the network: {command} --host 0.0.0.0 --tls", ""]
    if not settings.tls:
        return ["On other machines gamepads need https: add --tls.", ""]
    return ["The certificate is self-signed: the browser asks once whether to trust it.", ""]


def _bracketed(host: str) -> str:
    return f"[{host}]" if ":" in host else host
