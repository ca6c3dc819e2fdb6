"""`movingout study serve`: check the study, print the links, run until it is interrupted."""

import argparse
import asyncio
import os
import sys
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from fastapi import FastAPI

from movingout.maps.files.terminal import printable_lines
from movingout.server.commands.play import (
    addresses,
    as_node,
    certificate_for,
    hints,
    shown_token,
    tell_cautions,
    with_kept_token,
)
from movingout.server.connection.asgi import App
from movingout.server.host import Host
from movingout.server.monitoring.logs import log_to
from movingout.server.options import values_of
from movingout.server.persistence.data_folder import (
    exclusive_data_folder,
    refuse_cluster_folder,
    told_interrupted,
    told_of_other_studies,
)
from movingout.server.persistence.recording_uploads import check_bucket
from movingout.server.processes.front import Front
from movingout.server.processes.front_endpoint import FrontEndpoint
from movingout.server.processes.front_server import front_server
from movingout.server.public_host import PublicHost
from movingout.server.security.certificate import Certificate
from movingout.server.settings import Limits, Settings
from movingout.server.study.api.app import create_study_app
from movingout.server.study.arrivals.admission import Admission
from movingout.server.study.commands.partner_timing import tell_ready
from movingout.server.study.commands.serve_node import folder_of_node, serve_node
from movingout.server.uvicorn_server import game_server, listen
from movingout.study.commands.data import earlier_seats_told, older_database_told
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.definition import Study
from movingout.study.design.partner_speed import slow_partners
from movingout.study.design.review import Review, review
from movingout.study.design.study_file import complete_text, plain_text, read_study
from movingout.study.errors import StudyError
from movingout.study.store.frozen_study import frozen_study, has_begun

SWITCH_S = 0.0005  # the database thread yields to a tick within this time
AT_ONE_ADDRESS = 1000  # a whole class may share one address
FASTEST = 50.0


class _Frozen(NamedTuple):
    """What a data folder holds of the study."""

    text: str | None  # of the study file, if it was served before
    begun: bool  # whether somebody has consented: until then the file may change


def serve(args: argparse.Namespace) -> int:
    """Run the command and return its exit code. Raises MovingOutError."""
    study = read_study(args.file)
    found = review(study)
    _refuse_faulty(found.missing, args.file)
    settings = _settings(args, study.id)
    admission = Admission(args.codes, args.signed, args.any_device, simulated=args.rehearse is not None)
    if settings.in_cluster:
        folder = folder_of_node(as_node(settings), study, args.database, args.identities)
        frozen = _frozen(folder)
        timed = _check_beginning(found, args, settings, begun=frozen.begun)
        sys.setswitchinterval(SWITCH_S)
        return serve_node(settings, folder, text_to_freeze(args.file, frozen.text), admission, timed)
    return _serve_alone(args, study, found, settings, admission)


def _serve_alone(
    args: argparse.Namespace, study: Study, found: Review, settings: Settings, admission: Admission
) -> int:
    """Serve the study from this machine alone, until the server is stopped; the exit code. Raises MovingOutError."""
    folder = StudyFolder(study, settings.data, args.database, args.identities)
    refuse_cluster_folder(settings.data)
    if settings.s3:
        check_bucket(settings.s3, settings.data)
    os.umask(0o077)  # what people do and say is for whoever runs the server
    tell_cautions(settings)
    with (
        exclusive_data_folder(settings.data) as lock,
        folder.exclusive(),
        closing(listen(settings.host, settings.port)) as listening,
    ):
        frozen = _frozen(folder)
        timed = _check_beginning(found, args, settings, begun=frozen.begun)
        settings = replace(with_kept_token(settings), port=listening.getsockname()[1])
        certificate = certificate_for(settings) if settings.tls else None
        log_to(form="json" if settings.log_format == "json" else "text")
        app = create_study_app(
            *_host(settings, lock, certificate),
            folder,
            text_to_freeze(args.file, frozen.text),
            **admission._asdict(),
        )
        code = asyncio.run(app.state.session_service.new_code()) if args.codes else ""
        links = _links(app, settings, folder, code)
        sys.setswitchinterval(SWITCH_S)
        server_of = game_server if settings.processes == 1 else front_server
        server = server_of(app, settings, certificate, on_ready=lambda: tell_ready(links, study, timed))
        server.run([listening])
    if told := told_interrupted(settings.data, study.id):
        print(told)
    return 0 if server.started else 1


def _host(settings: Settings, lock: int, certificate: Certificate | None) -> tuple[PublicHost, App]:
    """The rooms in this process or in several, and the endpoint for their websockets."""
    if settings.processes == 1:
        host = Host(settings)
        return host, host.endpoint
    front = Front(settings, settings.processes, lock, certificate)
    return front, FrontEndpoint(front)


def _check_beginning(found: Review, args: argparse.Namespace, settings: Settings, *, begun: bool) -> bool:
    """Raises StudyError for what keeps a study from beginning.

    One that has begun goes on, so that participants and their data are looked after: its agents are warned of alone.
    Returns whether its partners are to be timed while it is served.
    """
    if begun:
        for sentence in (*found.refused, *found.alike):
            print(printable_lines(f"warning: {sentence}"), file=sys.stderr)
        return args.rehearse is None and not settings.slow_agents
    _refuse_faulty((*found.refused, *found.alike), args.file)
    if args.rehearse is None:
        _refuse_blanks(found, args.file)
        _refuse_slow(found.study, settings)
    return False


def _refuse_faulty(faults: tuple[str, ...], file: Path) -> None:
    if faults:
        raise StudyError("\n".join([*faults, f"the study cannot run like this; see: movingout study check {file}"]))


def _refuse_blanks(found: Review, file: Path) -> None:
    if found.unfilled:
        help = f"participants would read this: fill it in in {file}, or rehearse with --rehearse 1"
        raise StudyError("\n".join([*found.unfilled, help]))


def _refuse_slow(study: Study, settings: Settings) -> None:
    """Before the first consent only: a study that has begun is not kept from going on by a slow hour."""
    if not settings.slow_agents and (slow := slow_partners(study)):
        raise StudyError("\n".join(slow))


def _frozen(folder: StudyFolder) -> _Frozen:
    try:
        with closing(folder.open_existing()) as store:
            return _Frozen(frozen_study(store).file_text, has_begun(store))
    except StudyError:
        return _Frozen(None, begun=False)


def text_to_freeze(file: Path, begun_with: str | None) -> str:
    """With the texts that the study keeps in files; studies of earlier versions began without them, or with marks.

    Neither these nor ends of lines, which programs of Windows write by themselves, make another text of it.
    """
    begun = None if begun_with is None else plain_text(begun_with)
    if begun_with is not None and begun == plain_text(file.read_text(encoding="utf-8")):
        return begun_with
    complete = complete_text(file)
    return begun_with if begun_with is not None and begun == plain_text(complete) else complete


def _settings(args: argparse.Namespace, study: str) -> Settings:
    speed: float = 1.0 if args.rehearse is None else args.rehearse
    if not 0.1 <= speed <= FASTEST:
        raise StudyError(f"--rehearse must be from 0.1 to {FASTEST:g}, not {speed:g}")
    limits = replace(
        Limits(),
        sockets_per_address=AT_ONE_ADDRESS,
        waiting_per_address=AT_ONE_ADDRESS,
        connections_per_address=2 * AT_ONE_ADDRESS,
        connects_per_address_per_minute=10 * AT_ONE_ADDRESS,
        accepts_per_address_per_s=AT_ONE_ADDRESS * max(1.0, speed),
        requests_per_address_per_s=AT_ONE_ADDRESS * max(1.0, speed),
        study_arrivals_per_minute=round(AT_ONE_ADDRESS * max(1.0, speed)),
        study_consents_per_day=round(Limits().study_consents_per_day * max(1.0, speed)),
        study_changes_per_s=Limits().study_changes_per_s * max(1.0, speed),
        study_answers_per_s=Limits().study_answers_per_s * max(1.0, speed),
        messages_per_s=Limits().messages_per_s * max(1.0, speed),
        message_burst=Limits().message_burst * max(1.0, speed),
    )
    return Settings(
        **values_of(args, Settings),
        countdown_s=Settings().countdown_s / speed,
        tick_s=Settings().tick_s / speed,
        study=study,
        lobby=False,
        limits=limits,
    )


def _links(app: FastAPI, settings: Settings, folder: StudyFolder, code: str) -> str:
    """The links to print after the start."""
    kind = " for simulated participants only" if app.state.running.admission.simulated else ""
    bases, token = addresses(settings), app.state.host.admin_token
    lines = ["", f"{folder.study.title.text()} ({folder.study.id}) is being served{kind}.", ""]
    lines += [f"  Participants   {base}/study" for base in bases]
    lines += (
        [f"  First code     {code}  {bases[0]}/study?code={code} (the experimenter's page makes more)"] if code else []
    )
    lines += [f"  Experimenter   {bases[0]}/experimenter", f"  Token          {shown_token(settings, token)}"]
    lines += [f"  Data           {settings.data.resolve()}", ""]
    if told := told_of_other_studies(settings.data, folder.study.id):
        lines += [told, ""]
    if warnings := [*older_database_told(folder), *earlier_seats_told(folder)]:
        lines += [*(f"warning: {sentence}" for sentence in warnings), ""]
    return "\n".join(lines + hints(settings, "movingout study serve FILE"))
