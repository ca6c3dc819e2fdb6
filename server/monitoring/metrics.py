"""What a server measures, in the format of Prometheus. Everything is read when it is asked for: ticks pay nothing."""

from collections import Counter
from collections.abc import Iterator
from typing import Any

from prometheus_client import CollectorRegistry, generate_latest
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily, HistogramMetricFamily, Metric
from prometheus_client.exposition import CONTENT_TYPE_PLAIN_1_0_0
from prometheus_client.registry import Collector

from movingout.server.monitoring.status import refused
from movingout.server.public_host import PublicHost
from movingout.server.rooms.lateness import Lateness

CONTENT_TYPE = CONTENT_TYPE_PLAIN_1_0_0
LATE_MS = 10.0
LATE_BUCKETS_MS = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)
PROCESS = "process"  # the label: number of a process with rooms, or the name of another one, "front" or "agents"
Reports = list[dict[str, Any]]


async def metrics_text(host: PublicHost) -> bytes:
    """All metrics of a server, with all its processes, in Prometheus's text format."""
    reports, others = await host.room_reports(), await host.other_reports()
    workers = [worker for each in (*reports, *others.values()) for worker in each.get("agents", ())]
    by_name = {str(each["process"]): each for each in reports} | others
    found = [*_ticks(reports), *_rooms(reports), *_agents(reports, workers), *_processes(by_name)]
    found += _server(host, reports)
    registry = CollectorRegistry(auto_describe=False)
    registry.register(_Scrape([*found, *(metric for source in host.metric_sources for metric in source())]))
    return generate_latest(registry)


class _Scrape(Collector):
    """Metrics that are there already."""

    def __init__(self, metrics: list[Metric]) -> None:
        self._metrics = metrics

    def collect(self) -> Iterator[Metric]:
        yield from self._metrics


def _ticks(reports: Reports) -> Iterator[Metric]:
    began, late, missed = (
        _by_process("ticks", "Ticks that began"),
        _by_process("ticks_late", "Ticks that began more than 10 ms late"),
        _by_process("ticks_missed", "Ticks that were skipped, because they were a whole tick late"),
    )
    histogram = HistogramMetricFamily("movingout_tick_lateness_seconds", "How late ticks began", labels=[PROCESS])
    for each in reports:
        lateness, process = Lateness(), [str(each["process"])]
        lateness.include(each["late"])
        began.add_metric(process, lateness.ticks)
        late.add_metric(process, lateness.later_than(LATE_MS))
        missed.add_metric(process, lateness.skipped)
        buckets = [(str(ms / 1e3), lateness.ticks - lateness.later_than(ms)) for ms in LATE_BUCKETS_MS]
        histogram.add_metric(process, [*buckets, ("+Inf", lateness.ticks)], sum_value=lateness.total_ms / 1e3)
    yield from (began, late, missed, histogram)


def _rooms(reports: Reports) -> Iterator[Metric]:
    rooms = GaugeMetricFamily("movingout_rooms", "Open rooms", labels=["phase"])
    phases = Counter(room["phase"] for each in reports for room in each["rooms"])
    for phase, number in sorted(phases.items()):
        rooms.add_metric([phase], number)
    yield rooms
    not_opened = sum(each["rooms_not_opened"] for each in reports)
    yield gauge("rooms_not_opened", "Rooms that wait for a start at which they can be opened", not_opened)
    unrecorded = "Rounds that ended and were not recorded, or not to their end, though they should have been"
    yield _by_process("rounds_unrecorded", unrecorded, reports, "rounds_unrecorded")
    yield gauge("sockets", "Connected players, programs and spectators", sum(each["sockets"] for each in reports))
    yield _by_process("sent_bytes", "Bytes sent over websockets", reports, "bytes_sent")


def _agents(reports: Reports, workers: list[dict[str, float]]) -> Iterator[Metric]:
    late = "Decisions that came too late for their tick"
    yield _by_process("agent_decisions", "Decisions that were due", reports, "agent_decisions")
    yield _by_process("agent_decisions_late", late, reports, "agent_decisions_late")
    seats = GaugeMetricFamily("movingout_agent_seats", "Seats played by a worker", labels=["worker"])
    load = GaugeMetricFamily("movingout_agent_load", "Share of one core its seats take", labels=["worker"])
    restarts = CounterMetricFamily("movingout_agent_restarts", "Times a worker was replaced", labels=["worker"])
    overruns = CounterMetricFamily(
        "movingout_agent_overruns", "Times a worker was replaced because an agent computed on", labels=["worker"]
    )
    for number, row in enumerate(workers):
        for family, key in ((seats, "seats"), (load, "load"), (restarts, "restarts"), (overruns, "overruns")):
            family.add_metric([str(number)], row[key])
    yield from (seats, load, restarts, overruns)


def _processes(by_name: dict[str, dict[str, Any]]) -> Iterator[Metric]:
    """Each process with what it reports."""
    keys = {
        "movingout_tick_share": ("Share of one core that ticks take", "tick_share", 1.0),
        "movingout_sync_age_seconds": ("Since recordings were last forced to the disk", "sync_age_s", 1.0),
        "process_resident_memory_bytes": ("Memory in use", "rss_mb", 1e6),
        "process_open_fds": ("Open files and sockets", "open_files", 1.0),
        "process_max_fds": ("How many may be open", "most_files", 1.0),
    }
    for name, (help, key, unit) in keys.items():
        family = GaugeMetricFamily(name, help, labels=[PROCESS])
        for process, each in by_name.items():
            if key in each:
                family.add_metric([process], each[key] * unit)
        yield family
    seconds = CounterMetricFamily("process_cpu_seconds", "Processor time", labels=[PROCESS])
    for process, each in by_name.items():
        seconds.add_metric([process], each["cpu_seconds"])
    yield seconds


def _server(host: PublicHost, reports: Reports) -> Iterator[Metric]:
    service = host.recording_service
    yield gauge("rooms_limit", "Rooms that may be open", host.most_rooms)
    yield gauge("recordings_unfinished", "Journals that could not be finished yet", len(service.unfinished))
    yield gauge("recordings_finishing", "Journals that are being finished", service.pending)
    standing = "Since the last of the journals that are being finished was done, 0 where there are none"
    yield gauge("recordings_finishing_seconds", standing, service.stands_still_s)
    waiting, sent, failing = (0, 0, False) if (sending := host.uploads) is None else sending.counts
    yield gauge("recordings_not_uploaded", "Recordings that wait to be sent to a bucket", waiting)
    yield counter("recordings_uploaded", "Recordings sent to a bucket since the start", sent)
    yield gauge("upload_failing", "Whether the last attempt to send a recording failed", failing)
    yield gauge(
        "disk_free_bytes",
        "Free on the disk of the data folder, or of its recordings where that has less",
        host.disk_free(),
    )
    refusals = CounterMetricFamily("movingout_refusals", "What was refused", labels=["reason", PROCESS])
    for process, counts in refused(host, reports).items():
        for reason, number in sorted(counts.items()):
            refusals.add_metric([reason, process], number)
    yield refusals
    yield gauge("faults", "What does not work; /healthz names it", len(host.faults()))
    yield gauge("ready", "Whether a room can be opened now", not host.why_not_ready())


def counter(name: str, help: str, value: float) -> CounterMetricFamily:
    """A count since the start; Prometheus adds _total."""
    return CounterMetricFamily(f"movingout_{name}", help, value=value)


def _by_process(name: str, help: str, reports: Reports | tuple[()] = (), key: str = "") -> CounterMetricFamily:
    """Counts of each process with rooms: of a sum, Prometheus would take the end of one process for the end of all, and
    what the others had counted for new."""
    family = CounterMetricFamily(f"movingout_{name}", help, labels=[PROCESS])
    for each in reports:
        family.add_metric([str(each["process"])], each[key])
    return family


def gauge(name: str, help: str, value: float) -> GaugeMetricFamily:
    return GaugeMetricFamily(f"movingout_{name}", help, value=value)
