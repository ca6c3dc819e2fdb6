"""Command-line options made from the settings: stable on the outside, declared once inside."""

import argparse
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import pytest

from movingout.server.cli import main
from movingout.server.commands import play
from movingout.server.options import add_options, option, values_of
from movingout.server.settings import AGENT_WORKERS, Limits, Settings

PLAY = (
    "--host", "--port", "--partner", "--data", "--tls", "--origin", "--allow-host", "--proxy", "--maps", "--countdown",
    "--agent-workers", "--agent-threads", "--slow-agents", "--processes", "--cluster", "--node", "--lease", "--s3",
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


@pytest.mark.parametrize(
    ("words", "why"),
    [
        ("--host=", "write 127.0.0.1 (this machine only) or 0.0.0.0 (the network too)"),
        ("--data=", "name a folder; the current one is ."),
        ("--cluster=", "--cluster: the value is empty; give one, or leave the option out"),
        ("--s3=", "--s3: the value is empty; give one, or leave the option out"),
        ("--node=", "--node: a name has up to 31 letters, digits and '-', not ''"),
        ("--port 65536", "--port: a port is a number from 0 to 65535, not 65536"),
        ("--port -1", "a port is a number from 0 to 65535, not -1"),
        ("--agent-threads 0", "--agent-threads: from 0.05 to 64 cores are possible, not 0"),
        ("--max-rooms 0", "a whole number from 1 to 1,000,000 is possible, not 0"),
        ("--max-sockets -2", "a whole number from 1 to 1,000,000 is possible, not -2"),
        ("--proxy caddy", "a proxy is named by its address, such as 10.0.0.9 or 10.0.0.0/24, not 'caddy'"),
        ("--proxy 10.0.0.5/8", "not '10.0.0.5/8'"),
        (
            "--proxy *",
            "nobody would have limits if everybody were a proxy; name its network, such as --proxy 10.0.0.0/8",
        ),
        ("--proxy 0.0.0.0/0", "name its network, such as --proxy 10.0.0.0/8"),
        ("--proxy 0.0.0.0/0.0.0.0", "name its network, such as --proxy 10.0.0.0/8"),
        ("--proxy ::/0", "name its network, such as --proxy 10.0.0.0/8"),
        ("--proxy ::ffff:0:0/96", "name its network, such as --proxy 10.0.0.0/8"),
        ("--proxy ::/8", "name its network, such as --proxy 10.0.0.0/8"),
        ("--allow-host https://study.example.org", "without https:// and without a port"),
        ("--allow-host study.example.org:443", "without https:// and without a port"),
        ("--origin study.example.org", "an origin looks like https://study.example.org"),
        ("--origin https://study.example.org/lab", "an origin looks like https://study.example.org"),
        ("--origin http://[bad", "an origin looks like https://study.example.org"),
    ],
)
def test_what_no_request_could_match_is_refused(capsys: pytest.CaptureFixture[str], words: str, why: str) -> None:
    """An unset variable as --host served all networks, and the server said that only this machine can connect."""
    with pytest.raises(SystemExit):
        parser().parse_args(words.split())
    assert why in capsys.readouterr().err


def test_names_and_origins_are_compared_as_browsers_write_them() -> None:
    words = "--allow-host Study.Example.org. --origin https://Study.example.org/ --proxy ::1 --proxy 10.0.0.0/24"
    given = Settings(**values_of(parser().parse_args(words.split()), Settings))
    assert given.allowed_hosts == ("study.example.org",)
    assert given.origins == ("https://study.example.org",)
    assert given.trusted_proxies == ("::1", "10.0.0.0/24")


@pytest.mark.parametrize(
    "networks",
    ["0.0.0.0/1 128.0.0.0/1", "::/1 8000::/1", "::ffff:0:0/97 ::ffff:128.0.0.0/97", "0.0.0.0/1 ::ffff:128.0.0.0/97"],
)
def test_networks_that_are_everybody_together_are_refused(
    networks: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The first address in X-Forwarded-For, which whoever asks has written, was that of who asks."""
    words = [word for network in networks.split() for word in ("--proxy", network)]
    with suppress(SystemExit):  # where one of them is refused alone
        assert main(["play", "--data", str(tmp_path / "data"), *words]) == 2
    assert "nobody would have limits if everybody were a proxy" in capsys.readouterr().err
    assert not (tmp_path / "data").exists()


def test_large_networks_may_be_those_of_proxies() -> None:
    Settings(trusted_proxies=("0.0.0.0/1", "8000::/1", "10.0.0.9", "::1", "::ffff:10.0.0.0/104"))
