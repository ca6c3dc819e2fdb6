"""The table of metrics: one place that names them, and the rim where None becomes a number."""

from dataclasses import fields
from math import isfinite

from movingout.world.metrics import METRICS, NO_VALUE, Metrics, from_numbers, to_numbers

FULL = Metrics.of({metric.key: 0.5 for metric in METRICS})


def test_every_metric_has_a_row_and_every_row_a_metric() -> None:
    assert [field.name for field in fields(Metrics)] == [metric.key for metric in METRICS]
    assert list(FULL.values()) == [metric.key for metric in METRICS]


def test_values_come_back_from_their_dictionary() -> None:
    assert Metrics.of(FULL.values()) == FULL
    nothing = Metrics.of({"tcr": 0.0, "nfd": -1.0, "wt_s": 2.0})
    assert nothing.ac is None and Metrics.of(nothing.values()) == nothing


def test_none_is_a_number_in_files_and_comes_back_as_none() -> None:
    values = Metrics.of({"tcr": 0.0, "nfd": -1.0, "wt_s": 2.0}).values()
    numbers = to_numbers(values)
    assert numbers["ac"] == NO_VALUE and all(isfinite(number) for number in numbers.values())
    assert from_numbers(numbers) == values, "an NFD of -1 is a value"


def test_a_metric_that_an_older_file_does_not_have_is_none() -> None:
    assert from_numbers({"tcr": 1.0, "nfd": 1.0, "wt_s": 0.0})["ac"] is None


def test_how_a_value_is_shown() -> None:
    by_key = {metric.key: metric for metric in METRICS}
    assert (by_key["wt_s"].heading, by_key["wt_s"].text(1.25), by_key["wt_s"].bounds) == ("WT [s]", "1.2 s", "s")
    assert (by_key["tcr"].heading, by_key["tcr"].text(None), by_key["tcr"].bounds) == ("TCR", "–", "[0, 1]")
    assert by_key["nfd"].bounds == ""


def test_the_bounds_hold_and_each_says_when_it_has_no_value() -> None:
    for metric in METRICS:
        assert metric.low is None or metric.high is None or metric.low < metric.high
        assert metric.meaning and metric.title[0].isupper() and metric.key.islower()
