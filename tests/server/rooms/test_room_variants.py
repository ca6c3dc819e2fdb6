"""A room waits for the varied map of its next round, and ends the series where there is none."""

from movingout.maps import MapError
from movingout.server import messages as m
from tests.server.support import Ear, FakeServices, Table


def over(services: FakeServices) -> tuple[Table, Ear, Ear]:
    """A series whose first round is over, and two people who are ready for the second one."""
    table = Table("Simple", "HandOff", services=services, limit_ticks=10, challenge2_seed=5)
    blue, red = table.play()
    table.step(12)
    assert table.phase == "round_over"
    table.ready(blue, red)
    return table, blue, red


def test_a_round_begins_when_its_map_is_there() -> None:
    services = FakeServices()
    services.maps_ready = False
    table, _, _ = over(services)
    table.seconds(2)
    assert table.phase == "round_over" and table.room.series.index == 0
    services.maps_ready = True
    table.step()
    assert table.phase == "countdown" and table.room.series.index == 1


def test_where_a_map_cannot_be_varied_the_series_ends_and_is_not_tried_at_each_tick() -> None:
    services = FakeServices()
    services.maps_ready = MapError("no playable train variant")
    table, blue, red = over(services)
    table.step()
    assert (table.phase, table.room.notice.code) == ("series_over", "cannot_start")
    table.say(blue, m.Again(0))
    table.say(red, m.Again(1))
    table.step()
    said = len(blue.told)
    table.step(5)
    assert len(blue.told) == said and table.phase == "series_over"
