"""Which randomised maps the node that runs the study sends to the others, and how long they count as known there."""

import asyncio
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from movingout.maps import load_map
from movingout.server.cluster.study import host as study_host
from movingout.server.cluster.study.host import StudyNodeHost
from movingout.server.public_host import Away
from movingout.server.settings import Settings


class Host(StudyNodeHost):
    """Sends maps to the nodes whose runs are in `runs`, of which those in `silent` do not answer."""

    def __init__(self, data: Path) -> None:
        super().__init__(Settings(data=data, cluster="postgresql://h/d", node="a"), "a study")
        self.runs, self.silent, self.sent = ["one", "two"], set[str](), list[tuple[str, int]]()

    def _nodes(self) -> list[Any]:
        return [SimpleNamespace(run=run) for run in self.runs]

    async def _call(self, node: Any, work: Any, *args: Any, within_s: float = 3.0) -> None:
        if node.run in self.silent:
            raise Away("it does not answer")
        self.sent.append((node.run, args[1]))

    def prepare(self, *seeds: int) -> list[tuple[str, int]]:
        """What was sent."""
        designed = load_map("HandOff")
        for seed in seeds:
            self.keep_map((designed, seed, "train"), designed)
        self.sent.clear()
        asyncio.run(self._prepare([(designed, seed, "train") for seed in seeds], ""))
        return self.sent


def test_a_map_is_sent_to_each_run_of_a_node_once_and_again_when_it_may_be_gone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(study_host, "SENT", 2)
    host = Host(tmp_path)
    assert host.prepare(1) == [("one", 1), ("two", 1)]
    assert host.prepare(1) == []
    host.silent = {"two"}
    assert host.prepare(2, 3) == [("one", 2), ("one", 3)]
    host.silent = set()
    assert host.prepare(2) == [("two", 2)], "it has not heard of it"
    assert host.prepare(1) == [("one", 1)], "two have come since"
    host.runs = ["one", "three"]
    assert host.prepare(3) == [("three", 3)]
    assert set(host._sent) == {"one", "three"} and all(len(sent) <= 2 for sent in host._sent.values())
