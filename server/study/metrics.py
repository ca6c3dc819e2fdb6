"""What a running study adds to the metrics and to the health of its server. No names, no pseudonyms: only counts."""

from collections import Counter
from collections.abc import Iterator
from typing import get_args

from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily, Metric

from movingout.server.monitoring.metrics import counter, gauge
from movingout.server.notices import AlertCode
from movingout.server.study.running_study import RunningStudy


def study_metrics(running: RunningStudy) -> Iterator[Metric]:
    """Participants by outcome, who waits, rounds, alerts."""
    participants = GaugeMetricFamily("movingout_study_participants", "People in the study", labels=["outcome"])
    outcomes = Counter(session.record.outcome or "under way" for session in running.participants)
    for outcome, number in sorted(outcomes.items()):
        participants.add_metric([outcome], number)
    yield participants
    yield gauge("study_planned", "Participants that the study needs", running.study.participants)
    yield gauge("study_waiting", "People who wait for a partner", running.units.waiting_count)
    yield counter("study_rounds_recorded", "Rounds with a recording", running.rooms.finished.recorded)
    alerts = CounterMetricFamily("movingout_study_alerts", "Alerts to the experimenter", labels=["code"])
    for code in get_args(AlertCode):
        alerts.add_metric([code], running.alerts.counts[code])
    yield alerts


def study_faults(running: RunningStudy) -> Iterator[str]:
    """What does not work of the study."""
    if running.databases.problem:
        yield "the database of the study does not answer"
