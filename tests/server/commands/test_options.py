"""Command-line options made from the settings: stable on the outside, declared once inside."""

import argparse
from dataclasses import dataclass
from pathlib import Path

import pytest

from movingout.server.commands import play
from movingout.server.options import add_options, option, values_of
from movingout.server.settings import AGENT_WORKERS, Limits, Settings

PLAY = (
    "--host", "--port", "--partner", "--data", "--tls", "--origin", "--allow-host", "--proxy", "--maps", "--countdown",
    "--agent-workers", "--agent-threads", "--processes", "--cluster", "--node", "--lease", "--s3",
        "--log-format", "--max-rooms", "--max-sockets",
)  # fmt: skip


def parser() -> argparse.ArgumentParser:
    made = argparse.ArgumentParser()
    play.configure(made)
    return made


def test_play_has_the_options_it_always_had() -> None:
    offered = [action.option_strings[0] for action in parser()._actions[1:]]
    assert tuple(offered) == PLAY
    assert all(flag in parser().format_help() for flag in PLAY)


def test_what_is_given_becomes_the_settings() -> None:
    words = "--host :: --port 0 --data there --tls --origin https://a --origin https://b --countdown 0.5 --max-rooms 3"
    given = values_of(parser().parse_args(words.split()), Settings)
    assert Settings(**given) == Settings(
        host="::", port=0, data=Path("there"), tls=True, origins=("https://a", "https://b"), countdown_s=0.5,
        agent_workers=AGENT_WORKERS,
    )  # fmt: skip
    assert values_of(parser().parse_args(words.split()), Limits) == {"rooms": 3, "sockets_per_address": 200}


def test_a_declared_field_becomes_an_option_with_its_default_in_the_help() -> None:
    @dataclass(frozen=True)
    class Weather:
        wind_speed: float = option(2.5, "how hard it blows (%(default)s)", metavar="S", parse=float)
        clouds: int = 3

    made = argparse.ArgumentParser()
    add_options(made, Weather)
    assert "--wind-speed S" in made.format_help() and "how hard it blows (2.5)" in made.format_help()
    assert values_of(made.parse_args([]), Weather) == {"wind_speed": 2.5}
    assert Weather(**values_of(made.parse_args(["--wind-speed", "4"]), Weather)) == Weather(4.0, 3)


def test_a_field_can_be_left_out() -> None:
    made = argparse.ArgumentParser()
    add_options(made, Settings, without=("partner",))
    with pytest.raises(SystemExit):
        made.parse_args(["--partner", "scripted"])
