"""Metrics, health and readiness: true to what happens, and without a name of anybody."""

import asyncio
import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest
import yaml
from prometheus_client.parser import text_string_to_metric_families

from movingout.server.host import Host
from movingout.server.monitoring.status import room_report
from movingout.server.rooms.seat import Seat
from movingout.server.rooms.services import RoomConfig
from movingout.server.settings import Settings
from tests.server.live import ADMIN, Live, limits, serve
from tests.server.study.support import served

DEPLOY = Path(__file__).parents[3] / "deploy" / "monitoring"
STUDY_ONLY = "movingout_study_"


def scraped(live: Live) -> dict[str, float]:
    """The samples by name and labels."""
    status, text = live.call("/metrics", token=ADMIN)
    assert status == 200
    families = text_string_to_metric_families(text.decode())
    return {
        sample.name + "".join(f",{key}={value}" for key, value in sorted(sample.labels.items())): sample.value
        for family in families
        for sample in family.samples
    }


def test_the_metrics_need_the_token_as_the_status_does(live: Live) -> None:
    assert live.call("/metrics")[0] == 401
    assert live.call("/metrics", token="x" * 22)[0] == 403


@pytest.mark.slow
def test_the_metrics_count_what_happened(tmp_path: Path) -> None:
    with serve(tmp_path, limits(rooms=2)) as live:
        room = live.open_room("here", "idle", limit_ticks=10)
        person = live.person(room["room"], tokens=[room["tokens"][0]])
        person.say(type="ready", seat=0)
        person.wait_for("result")
        live.open_room("here", "idle")
        assert live.call("/api/rooms", {"maps": ["Simple"], "seats": []})[0] == 503
        found = scraped(live)
    assert found["movingout_ticks_total,process=0"] >= 10 and found["movingout_sockets"] == 1
    lateness = "movingout_tick_lateness_seconds"
    assert found[f"{lateness}_bucket,le=+Inf,process=0"] == found[f"{lateness}_count,process=0"]
    assert found["movingout_rooms,phase=series_over"] == found["movingout_rooms,phase=lobby"] == 1
    assert found["movingout_refusals_total,process=0,reason=full"] == 1
    assert found["movingout_rooms_not_opened"] == 0
    assert found["movingout_ready"] == 0 and found["movingout_faults"] == 0
    assert found["process_open_fds,process=0"] > 10 and found["process_resident_memory_bytes,process=0"] > 1e7
    assert found["movingout_sync_age_seconds,process=0"] < 5 and found["movingout_disk_free_bytes"] > 0


def test_a_round_that_is_not_recorded_counts_and_practice_does_not(tmp_path: Path) -> None:
    host = Host(Settings(data=tmp_path))
    host.settings.recordings.write_text("no folder")
    for practice in (False, True):
        room = host.registry.open(RoomConfig(maps=("Simple",), practice=practice), [Seat(0, "human"), Seat(1, "idle")])
        room.series.begin(room.round)
        assert not room.recording
        room._end_round("stopped")
    host.store.close()
    assert room_report(host)["rounds_unrecorded"] == 1


@pytest.mark.slow
def test_no_metric_names_anybody(tmp_path: Path) -> None:
    with served(tmp_path) as study:
        visitor = study.visitor(PROLIFIC_PID="jane-doe").go_to("form")
        _, text = study.live.call("/metrics", token=ADMIN)
        found = scraped(study.live)
        assert found["movingout_study_participants,outcome=under way"] == 1
        assert found["movingout_study_planned"] == 400
        assert visitor.pid.encode() not in text and b"jane" not in text


def test_health_and_readiness_are_true_to_what_works(tmp_path: Path) -> None:
    with serve(tmp_path, limits(rooms=1), lobby=False) as live:
        assert live.call("/healthz") == (200, {"ok": True, "rooms": 0, "faults": []})
        wait_until_ready(live)
        live.call("/api/rooms", {"maps": ["Simple"], "seats": [{"kind": "here"}, {"kind": "link"}]}, ADMIN)
        status, answer = live.call("/readyz")
        assert status == 503 and "All 1 rooms" in answer["reasons"][0]
        assert live.call("/healthz")[0] == 200, "a full server is well"
        live.host.checks.append(lambda: iter(["the disk is on fire"]))
        assert live.call("/healthz")[1] == {"ok": False, "rooms": 1, "faults": ["the disk is on fire"]}
        assert "the disk is on fire" in live.call("/readyz")[1]["reasons"]
        assert scraped(live)["movingout_faults"] == 1


def wait_until_ready(live: Live) -> None:
    async def worker() -> None:
        while not live.host.agents.connected:
            await asyncio.sleep(0.05)

    asyncio.run_coroutine_threadsafe(asyncio.wait_for(worker(), 60), live.loop).result(70)
    assert live.call("/readyz") == (200, {"ready": True, "reasons": []})


def test_a_study_without_its_database_is_not_well(tmp_path: Path) -> None:
    with served(tmp_path) as study:
        study.running.databases.problem = "disk I/O error in /srv/secret/study.sqlite"
        study.running.databases.run = None  # type: ignore[method-assign, assignment]
        status, answer = study.live.call("/healthz")
        assert status == 503 and answer["faults"] == ["the database of the study does not answer"]


# ---- the example files for operators --------------------------------------------------------------------------------


def test_dashboard_alerts_and_documentation_use_metrics_that_exist(tmp_path: Path) -> None:
    with served(tmp_path) as study:
        study.visitor()
        study.live.call("/metrics", token="x" * 22)
        found = scraped(study.live)
    assert found["movingout_study_alerts_total,code=disk"] == 0, "the alerts of one code apart from all others"
    known = {name.partition(",")[0] for name in found}
    # Of agents, which this study has none of: tests/server/processes/test_health.py.
    known |= {"movingout_agent_load", "movingout_agent_seats", "movingout_agent_restarts_total", "movingout_rooms"}
    known |= {"movingout_agent_overruns_total"}
    dashboard = json.loads((DEPLOY / "grafana-dashboard.json").read_text())
    rules = yaml.safe_load((DEPLOY / "alerts.yml").read_text())["groups"][0]["rules"]
    asked = [target["expr"] for panel in dashboard["panels"] for target in panel["targets"]]
    asked += [rule["expr"] for rule in rules]
    names = set(re.findall(r"\b(?:movingout|process)_\w+", " ".join(asked)))
    assert len(names) > 20 and names <= known
    page = (DEPLOY.parents[1] / "docs" / "deploy.md").read_text(encoding="utf-8")
    named = set(re.findall(r"`(movingout_\w+|process_\w+)`", page)) - {"movingout_cluster", "movingout_identities"}
    assert len(named) > 2 and named <= known, "two of the names are schemas"
    assert len({panel["id"] for panel in dashboard["panels"]}) == len(dashboard["panels"]) == 19


def test_somebody_is_told_when_no_room_can_be_opened() -> None:
    """A node whose database is away has no fault: it goes on by itself."""
    rules = yaml.safe_load((DEPLOY / "alerts.yml").read_text())["groups"][0]["rules"]
    [rule] = [rule for rule in rules if "movingout_ready" in rule["expr"]]
    assert rule["expr"] == 'movingout_ready{job="movingout"} == 0' and rule["labels"]["severity"] == "page"


@pytest.mark.skipif(shutil.which("promtool") is None, reason="promtool is not installed")
def test_promtool_accepts_rules_and_metrics(live: Live) -> None:
    for arguments in (["check", "rules", "alerts.yml"], ["test", "rules", "alerts_test.yml"]):
        subprocess.run(["promtool", *arguments], cwd=DEPLOY, check=True, capture_output=True)
    _, text = live.call("/metrics", token=ADMIN)
    subprocess.run(["promtool", "check", "metrics"], input=text, check=True, capture_output=True)
