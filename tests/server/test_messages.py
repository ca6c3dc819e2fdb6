"""Control messages against the text of the first version of `movingout.v1`: one example of each."""

import json
from pathlib import Path
from typing import Any, get_args

import msgspec
import pytest

from movingout.server import messages as m

GOLDEN = json.loads((Path(__file__).parent / "golden_messages.json").read_text())
UNIONS: dict[str, Any] = {"client": m.ClientMessage, "server": m.ServerMessage}


@pytest.mark.parametrize("golden", GOLDEN["messages"], ids=lambda golden: str(golden["tag"]))
def test_a_message_has_its_golden_text_and_comes_back_from_it(golden: dict[str, Any]) -> None:
    message = msgspec.json.decode(golden["text"], type=UNIONS[golden["direction"]])
    assert type(message).__name__ == golden["name"]
    # Clients ignore fields that they do not know, so a server's message may have more of them, at its end.
    assert msgspec.json.encode(message).decode().startswith(golden["text"].removesuffix("}"))


def test_every_message_has_a_golden_example() -> None:
    for direction, union in UNIONS.items():
        named = [golden["name"] for golden in GOLDEN["messages"] if golden["direction"] == direction]
        assert named == [message.__name__ for message in get_args(union)]


@pytest.mark.parametrize("golden", GOLDEN["client_defaults"], ids=lambda golden: str(golden["means"]["type"]))
def test_what_a_client_leaves_out_keeps_its_meaning(golden: dict[str, Any]) -> None:
    decoded = msgspec.json.decode(golden["text"], type=m.ClientMessage)
    assert msgspec.to_builtins(decoded) == golden["means"]


@pytest.mark.parametrize("name", GOLDEN["constants"])
def test_codes_and_scales_stay(name: str) -> None:
    value = getattr(m, name)
    assert (list(value) if isinstance(value, tuple) else value) == GOLDEN["constants"][name]
