"""What `movingout play` prints at its start."""

from pathlib import Path

import pytest

from movingout.server.cli import main
from movingout.server.commands.play import hints
from movingout.server.settings import Settings


@pytest.mark.parametrize(
    ("settings", "hint"),
    [
        (Settings(), "Only this machine can connect. For others in the network: movingout play --host 0.0.0.0 --tls"),
        (Settings(host="0.0.0.0"), "On other machines gamepads need https: add --tls."),
        (Settings(tls=True), "The certificate is self-signed: the browser asks once whether to trust it."),
        (Settings(trusted_proxies=("127.0.0.1",)), "These addresses lie behind the proxy; give people the proxy's."),
        (
            Settings(host="0.0.0.0", trusted_proxies=("*",)),
            "These addresses lie behind the proxy; give people the proxy's.",
        ),
    ],
)
def test_the_hint_says_who_can_connect(settings: Settings, hint: str) -> None:
    assert hints(settings, "movingout play") == [hint, ""]


@pytest.mark.parametrize(
    ("partner", "sentence"),
    [
        ("no_such_module:Policy", "cannot import 'no_such_module': ModuleNotFoundError"),
        ("tests.agents.support:broken_factory", "could not be made: RuntimeError: no weights here (tests/agents"),
        ("scripted:patience=abc", "style: patience must lie between"),
    ],
)
def test_a_partner_that_cannot_be_made_is_refused_at_the_start(
    partner: str, sentence: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["play", "--partner", partner, "--port", "0", "--data", str(tmp_path)]) == 2
    assert sentence in capsys.readouterr().err
