"""Control messages against the text of the first version of `movingout.v1`: one example of each."""

import json
import re
from pathlib import Path
from typing import Any, get_args

import msgspec
import pytest

from movingout.server import messages as m
from tests.support import ROOT

GOLDEN = json.loads((Path(__file__).parent / "golden_messages.json").read_text())
SERVER_TAGS = {message.__struct_config__.tag for message in get_args(m.ServerMessage)}
UNIONS: dict[str, Any] = {"client": m.ClientMessage, "server": m.ServerMessage}


@pytest.mark.parametrize("golden", GOLDEN["messages"], ids=lambda golden: str(golden["tag"]))
def test_a_message_has_its_golden_text_and_comes_back_from_it(golden: dict[str, Any]) -> None:
    message = msgspec.json.decode(golden["text"], type=UNIONS[golden["direction"]])
    assert type(message).__name__ == golden["name"]
    known = _of_before(json.loads(msgspec.json.encode(message)), json.loads(golden["text"]))
    assert json.dumps(known, separators=(",", ":")) == golden["text"]


def _of_before(now: Any, golden: Any) -> Any:
    """Clients ignore fields that they do not know, so each object may have more of them, at its end."""
    if isinstance(golden, dict):
        return {key: _of_before(now[key], golden[key]) for key in [*now][: len(golden)]}
    if isinstance(golden, list):
        return [_of_before(*pair) for pair in zip(now, golden, strict=True)]
    return now


def test_every_message_has_a_golden_example() -> None:
    for direction, union in UNIONS.items():
        named = [golden["name"] for golden in GOLDEN["messages"] if golden["direction"] == direction]
        assert named == [message.__name__ for message in get_args(union)]


def tags_in(pattern: str, *paths: Path) -> set[str]:
    return {tag for path in paths for tag in re.findall(pattern, path.read_text(encoding="utf-8"))}


def test_the_protocol_names_every_message_of_the_server() -> None:
    text = (ROOT / "docs" / "protocol.md").read_text(encoding="utf-8")
    from_server = text.partition("\nFrom the server:")[2].partition("\n## ")[0]
    assert {tag for tag in SERVER_TAGS if f"`{tag}`" not in from_server} == set()


def test_every_client_takes_each_message_of_the_server_or_is_known_to_pass_over_it() -> None:
    """Two clients passed over `error`, and waited for ever for what was refused."""
    of_a_script = r'message\.type === "(\w+)"'
    pages = [*(ROOT / "web" / "play").glob("*.js"), ROOT / "web" / "wire" / "connection.js"]
    taken = {
        "pages": tags_in(of_a_script, *pages),
        "Python": tags_in(r'(?:case|\["type"\] !=) "(\w+)"', ROOT / "src" / "movingout" / "remote.py"),
        "JavaScript": tags_in(of_a_script, ROOT / "examples" / "javascript-client" / "client.js"),
    }
    passed_over = {"keyframe", "tutorial"}  # bundles have the state, and programs play no tutorials
    assert taken == {"pages": SERVER_TAGS, "Python": SERVER_TAGS - passed_over, "JavaScript": SERVER_TAGS - passed_over}


@pytest.mark.parametrize("golden", GOLDEN["client_defaults"], ids=lambda golden: str(golden["means"]["type"]))
def test_what_a_client_leaves_out_keeps_its_meaning(golden: dict[str, Any]) -> None:
    decoded = msgspec.json.decode(golden["text"], type=m.ClientMessage)
    assert msgspec.to_builtins(decoded) == golden["means"]


@pytest.mark.parametrize("claim", [-1, 3])
def test_more_seats_than_there_are_can_not_be_claimed(claim: int) -> None:
    """The answer was that the room is full."""
    with pytest.raises(msgspec.ValidationError, match="claim"):
        msgspec.json.decode(json.dumps({"type": "join", "room": "a", "claim": claim}), type=m.ClientMessage)


@pytest.mark.parametrize("name", GOLDEN["constants"])
def test_codes_and_scales_stay(name: str) -> None:
    value = getattr(m, name)
    assert (list(value) if isinstance(value, tuple) else value) == GOLDEN["constants"][name]
