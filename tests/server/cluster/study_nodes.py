"""Nodes that serve a study, as processes of this machine, and simulated participants that reach them by a proxy."""

import asyncio
import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from movingout.recordings.storage.index import list_recordings
from movingout.recordings.verification import verify
from movingout.server.cluster.proxy_config import ProxyLimits
from movingout.server.study_bots.cohort import Cohort
from movingout.server.study_bots.data_check import StoredData, find_losses, read_stored
from movingout.server.study_bots.simulation_plan import SimulationPlan
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.study_file import read_study
from movingout.study.store.identity import identities_in
from tests.server.cluster.processes import NodeProcess, caddy, free_port, haproxy, status, wait_until
from tests.server.live import Live

MANY = ProxyLimits(connections=300, per_address=1000, new_per_10s=10_000, requests_per_10s=10_000)
STUDY = """
format: 1
id: crowd
title: A crowd
participants: 1000
consent:
  version: "1"
  text: "# Consent"
  boxes: [{id: adult, text: I am 18 or older., required: true}]
demographics: demographics
partners: [{id: good, agent: idle}, {id: bad, agent: idle}]
blocks:
  - {id: play, partners: [good, bad], maps: [HandOff], limit_ticks: 40, after_partner: [movingout-paper-nine]}
debrief: {text: "# Thank you"}
"""


@dataclass
class StudyNode(NodeProcess):
    """`movingout study serve FILE --cluster ... --node NAME --rehearse SPEED`."""

    file: Path = Path()
    speed: float = 10.0
    lease_s: float = 10.0
    environment: Mapping[str, str] = field(default_factory=dict)

    def start(self) -> None:
        command = [sys.executable, "-m", "movingout.server.cli", "study", "serve", str(self.file)]
        command += ["--port", str(self.port), "--data", str(self.data), "--cluster", self.database]
        command += ["--node", self.name, "--proxy", "127.0.0.1", "--agent-workers", "1", "--log-format", "json"]
        command += ["--lease", f"{self.lease_s:g}", "--rehearse", f"{self.speed:g}"]
        with self.log.open("ab") as log:
            environment = {**os.environ, **self.environment}
            self.process = subprocess.Popen(command, stdout=log, stderr=log, stdin=subprocess.DEVNULL, env=environment)

    @property
    def runs_the_study(self) -> bool:
        return status(self.port, "/cluster/rooms/study") == 200

    def kill(self) -> None:
        self.end(signal.SIGKILL)

    def folder(self) -> StudyFolder:
        """The data of the study, as its commands open them."""
        return StudyFolder(read_study(self.file), self.data, self.database, identities_in(self.database))

    def told(self, field: str = "message") -> list[str]:
        """This field of the lines of its log."""
        lines = self.log.read_text(encoding="utf-8").splitlines()
        return [str(json.loads(line)[field]) for line in lines if line.startswith("{")]


@dataclass
class StudyCluster:
    """Nodes that are ready, the proxy in front of them, and what simulated participants did there."""

    nodes: list[StudyNode]
    live: Live
    scheme: str = "http"
    over: threading.Event = field(default_factory=threading.Event)  # when everybody has come to the end

    def is_served(self) -> bool:
        return status(self.live.port, "/api/study", self.scheme) == 200

    def leader(self) -> StudyNode:
        found: StudyNode = wait_until(
            lambda: next((one for one in self.nodes if one.runs_the_study), None), "a node runs it"
        )
        return found

    def take_part(self, plan: SimulationPlan, trouble: Callable[[Cohort], None]) -> Cohort:
        """Everybody to the end, while `trouble` happens in a thread; then the nodes end."""
        cohort = Cohort(f"{self.scheme}://127.0.0.1:{self.live.port}", plan)
        with ThreadPoolExecutor(1) as thread:
            troubled = thread.submit(trouble, cohort)
            try:
                asyncio.run(cohort.take_part())
            finally:
                self.over.set()
            troubled.result()
        for node in self.nodes:
            node.end()
        return cohort

    def check(self, cohort: Cohort) -> StoredData:
        """Everything that the participants did is stored once, and every recording verifies."""
        folder = self.nodes[0].folder()
        stored = read_stored(folder)
        assert find_losses(folder, stored, cohort.logs) == []
        said = sum(len(log.saved_answers) for log in cohort.logs if not log.deleted)
        assert len(stored.answers) == said, "a repeated answer is one answer"
        assert len({row["code"] for row in stored.participants.values()}) == cohort.plan.participants
        found = list_recordings(folder.recordings)[0]
        assert found and all(verify(one.path).identical for one in found)
        return stored


def through(step: int, cohort: Cohort) -> Callable[[], bool]:
    """Whether somebody has reached this step."""
    return lambda: any(log.done >= step for log in cohort.logs)


@contextmanager
def study_cluster(
    folder: Path, database: str, data: Path | None = None, certificate: str = "", **node: Any
) -> Iterator[StudyCluster]:
    """Two nodes for one `with` block, behind HAProxy, or behind Caddy with TLS where there is a certificate.

    `data` is their shared folder, `node` fields of both.
    """
    file = folder / "study.yaml"
    file.write_text(STUDY, encoding="utf-8")
    fields = {"data": data or folder / "data", "database": database, "file": file, **node}
    nodes = [StudyNode(name, free_port(), **fields) for name in "ab"]
    for one in nodes:
        one.start()
    try:
        for one in nodes:
            wait_until(one.is_ready, f"node {one.name} is ready")
        with caddy(folder, nodes, certificate) if certificate else haproxy(folder, nodes, limits=MANY) as live:
            cluster = StudyCluster(nodes, live, "https" if certificate else "http")
            wait_until(cluster.is_served, "the proxy finds the study")
            yield cluster
    finally:
        for one in nodes:
            one.kill()
