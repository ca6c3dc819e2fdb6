"""The options of an agent's id as values."""

import pytest

from movingout.agents.agent_options import OptionValue, parse_options


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("3", 3), ("-0.5", -0.5), ("1e3", 1000.0), ("True", True), ("false", False), ("yes", "yes"),
        ("nan", "nan"), ("inf", "inf"), ("-Infinity", "-Infinity"), ("1e999", "1e999"), ("9" * 400, int("9" * 400)),
    ],
)  # fmt: skip
def test_finite_numbers_are_numbers_and_all_else_is_text(text: str, value: OptionValue) -> None:
    found = parse_options("mine:Agent", f"how={text}")["how"]
    assert (found, type(found)) == (value, type(value))
