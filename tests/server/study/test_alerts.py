"""Alerts for the experimenter: one is said once a minute, however its detail changes, and many hide no other."""

import io

from movingout.server.monitoring.logs import PER_MINUTE, log_to
from movingout.server.study.alerts import MAX_ALERTS, MOST_ALIKE, REPEAT_S, Alerts


def test_a_detail_with_a_changing_figure_does_not_repeat_an_alert_and_another_unit_does() -> None:
    now = [0.0]
    alerts = Alerts(lambda: now[0])
    alerts.add("room", "Unit 2 cannot play yet.", "the agents would need 125% of a core", unit=2)
    alerts.add("room", "Unit 2 cannot play yet.", "the agents would need 187% of a core", unit=2)
    alerts.add("room", "Unit 3 cannot play yet.", "the agents would need 187% of a core", unit=3)
    assert [one["values"] for one in alerts.to_json()] == [{"unit": 3}, {"unit": 2}]
    now[0] = REPEAT_S
    alerts.add("room", "Unit 2 cannot play yet.", unit=2)
    newest = alerts.to_json()[0]
    assert (newest["id"], newest["text"], newest["detail"]) == (3, "Unit 2 cannot play yet.", "")


def test_what_is_over_is_shown_no_more_counts_and_comes_again_at_once() -> None:
    alerts = Alerts(lambda: 0.0)
    for unit in (2, 3):
        alerts.add("room", f"Unit {unit} cannot play yet.", unit=unit)
    alerts.settle("room", unit=2)
    assert [one["values"] for one in alerts.to_json()] == [{"unit": 3}] and alerts.counts == {"room": 2}
    assert alerts.add("room", "Unit 2 cannot play yet.", unit=2)
    assert [one["id"] for one in alerts.to_json()] == [3, 2]


def test_a_clock_that_is_put_back_hides_no_alert() -> None:
    now = [10_000.0]
    alerts = Alerts(lambda: now[0])
    alerts.add("disk", "The disk is almost full.")
    now[0] -= 3600.0
    alerts.add("disk", "The disk is almost full.")
    assert len(alerts.to_json()) == 2


def test_a_name_in_a_detail_that_is_no_utf8_can_be_sent_to_the_page() -> None:
    alerts = Alerts()
    alerts.add("deletion", "The data of P1 could not be deleted.", "cannot read caf\udce9.mcap", pid="P1")
    assert alerts.to_json()[0]["detail"].encode() == rb"cannot read caf\udce9.mcap"


def test_many_alerts_of_one_kind_hide_no_other() -> None:
    alerts = Alerts()
    alerts.add("disk", "The disk is almost full.")
    for number in range(2 * MAX_ALERTS):
        alerts.add("away", f"P{number} has been away for two minutes.", pid=f"P{number}")
    found = alerts.to_json()
    assert [one["about"] for one in found] == ["away"] * MOST_ALIKE + ["disk"]
    assert found[0]["values"] == {"pid": f"P{2 * MAX_ALERTS - 1}"} and alerts.number == 2 * MAX_ALERTS + 1


def test_alerts_that_strangers_cause_silence_no_others_in_the_log() -> None:
    stream = io.StringIO()
    log_to(stream)
    alerts = Alerts()
    for number in range(100):
        alerts.add("controls", f"P{number} went on without trying every key.", pid=f"P{number}")
    alerts.add("database", "It could not be read.")
    lines = stream.getvalue().splitlines()
    assert len(lines) == 2 * PER_MINUTE + 1 and lines[-1].endswith("alert database: It could not be read.")
    assert alerts.counts == {"controls": 100, "database": 1}
