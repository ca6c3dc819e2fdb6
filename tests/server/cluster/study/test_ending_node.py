"""A node that ends while it begins the study gives its lease back at once: no other node waits until it runs out."""

import asyncio
import threading
from functools import partial
from pathlib import Path
from typing import Any

import psycopg
import pytest
from fastapi import FastAPI

from movingout.server.cluster.shards import STUDY
from movingout.server.cluster.study import app
from movingout.server.settings import Settings
from movingout.server.study.api.served_study import ServedStudy
from movingout.server.study.arrivals.admission import Admission
from movingout.server.study.participants import Participants
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.study_file import read_study
from movingout.study.store.identity import identities_in
from tests.server.cluster.study_nodes import STUDY as STUDY_FILE
from tests.server.live import serve

LEASE_S = 60.0  # it does not run out during the test
WAIT_S, LOOK_S = 30.0, 0.05
LEASE_LEFT = f"""SELECT l.expires - clock_timestamp() > interval '0' FROM movingout_cluster.lease AS l
JOIN movingout_cluster.node AS n ON n.name = 'a' WHERE l.shard = '{STUDY}' AND l.node = 'a' AND n.state = 'ended'"""


def study_node(file: Path, settings: Settings) -> FastAPI:
    folder = StudyFolder(read_study(file), settings.data, settings.cluster, identities_in(settings.cluster))
    return app.create_study_node(settings, folder, file.read_text(encoding="utf-8"), Admission(), "a study")


def gives_back(tmp_path: Path, database: str, begun: threading.Event, go_on: threading.Event) -> bool:
    """Stop a node once `begun` is set: whether it gives its lease back before `go_on`, which is set at last."""
    file = tmp_path / "study.yaml"
    file.write_text(STUDY_FILE, encoding="utf-8")
    found, ended = list[bool](), threading.Event()

    def watch() -> None:
        with psycopg.connect(database, autocommit=True) as connection:
            row, over = None, False
            for _ in range(round(WAIT_S / LOOK_S)):
                if row is None and not over:
                    over = ended.wait(LOOK_S)
                    row = connection.execute(LEASE_LEFT).fetchone()
            found.append(row == (False,))
        go_on.set()

    watching = threading.Thread(target=watch)
    try:
        with serve(tmp_path / "data", app_of=partial(study_node, file), cluster=database, node="a", lease_s=LEASE_S):
            assert begun.wait(WAIT_S)
            watching.start()
    finally:
        ended.set()
        go_on.set()
    watching.join()
    return found == [True]


def test_while_its_databases_are_opened_and_the_study_file_is_frozen(
    tmp_path: Path, database: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun, go_on = threading.Event(), threading.Event()

    class Slow(ServedStudy):
        def __init__(self, *args: Any) -> None:
            begun.set()
            go_on.wait(2 * WAIT_S)
            super().__init__(*args)

    monkeypatch.setattr(app, "ServedStudy", Slow)
    assert gives_back(tmp_path, database, begun, go_on)


def test_while_everybody_is_read_from_the_databases(
    tmp_path: Path, database: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nor does it note that those are here whom it has half read."""
    begun, noted = threading.Event(), list[str]()

    async def restore(*_: Any) -> float:
        begun.set()
        await asyncio.sleep(2 * WAIT_S)
        return 0.0

    async def note(*_: Any) -> None:
        noted.append("they are here")

    monkeypatch.setattr(Participants, "restore", restore)
    monkeypatch.setattr(Participants, "note_last_seen", note)
    assert gives_back(tmp_path, database, begun, threading.Event())
    assert not noted
