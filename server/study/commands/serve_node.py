"""`movingout study serve --cluster`: one node of several that serve a study."""

import os
from contextlib import closing
from dataclasses import replace
from hashlib import sha256

from movingout.server.cluster.errors import ClusterError
from movingout.server.cluster.study.app import create_study_node
from movingout.server.commands.play import as_node, shown_token, tell_cautions, with_kept_token
from movingout.server.monitoring.logs import log_to
from movingout.server.persistence.data_folder import exclusive_data_folder, refuse_served_folder
from movingout.server.persistence.recording_uploads import check_bucket
from movingout.server.settings import Settings
from movingout.server.study.arrivals.admission import Admission
from movingout.server.study.commands.partner_timing import tell_ready
from movingout.server.uvicorn_server import game_server, listen
from movingout.study.commands.data import earlier_seats_told, older_database_told
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.definition import Study
from movingout.study.store.identity import identities_in


def folder_of_node(settings: Settings, study: Study, database: str | None, identities: str | None) -> StudyFolder:
    """The study's databases: those that are named, else the cluster's own. Raises ClusterError, StudyError."""
    for option, address in (("--cluster", settings.cluster), ("--database", database), ("--identities", identities)):
        if address and not address.startswith(("postgresql://", "postgres://")):
            raise ClusterError(f"the nodes of a study share PostgreSQL databases; {option} {address} is none")
    return StudyFolder(
        study, settings.data, database or settings.cluster, identities or identities_in(database or settings.cluster)
    )


def serve_node(
    settings: Settings, folder: StudyFolder, file_text: str, admission: Admission, timed: bool = False
) -> int:
    """Run the command and return its exit code; partners are `timed` meanwhile. Raises MovingOutError."""
    settings = as_node(settings)
    refuse_served_folder(settings.data)
    os.umask(0o077)
    if settings.s3:
        check_bucket(settings.s3, settings.data)
    tell_cautions(settings)
    with (
        exclusive_data_folder(settings.node_folder),
        closing(listen(settings.host, settings.port)) as listening,
    ):
        settings = replace(with_kept_token(settings), port=listening.getsockname()[1])
        log_to(form="json" if settings.log_format == "json" else "text")
        digest = sha256(file_text.encode()).hexdigest()[:12]
        kind = f"study {folder.study.id} {digest}, ticks of {settings.tick_s:g} s, {admission}"
        app = create_study_node(settings, folder, file_text, admission, kind)
        links = _links(settings, folder)
        server = game_server(app, settings, None, on_ready=lambda: tell_ready(links, folder.study, timed))
        server.run([listening])
    return 0 if server.started else 1


def _links(settings: Settings, folder: StudyFolder) -> str:
    lines = [
        "",
        f"The node {settings.node} serves {folder.study.title.text()} ({folder.study.id}) at "
        f"http://{settings.host}:{settings.port}.",
        "",
        "  Participants   https://SITE/study, where SITE is the proxy (movingout cluster config)",
        "  Experimenter   https://SITE/experimenter",
        f"  Token          {shown_token(settings, settings.admin_token)}",
        f"  Data           {settings.data.resolve()}",
        "",
    ]
    if warnings := [*older_database_told(folder), *earlier_seats_told(folder)]:
        lines += [*(f"warning: {sentence}" for sentence in warnings), ""]
    return "\n".join(lines)
