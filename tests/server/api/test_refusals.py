"""What is said of a request body that is not understood."""

import msgspec
import pytest

from movingout.server.api.refusals import refusal
from movingout.server.api.room_requests import RoomRequest


@pytest.mark.parametrize(
    ("body", "sentence"),
    [
        (
            '{"seats": [{"kind": "here"}, {"kind": "robot"}]}',
            "Invalid enum value 'robot' - at `$.seats[1].kind`; known: agent, ghost, here, link, partner, remote",
        ),
        ('{"seats": [{"kind": "agnt"}]}', "did you mean agent? known: agent, ghost"),
        ('{"seats": [{"kind": "here", "agnt": "idle"}]}', "did you mean agent? known: kind, agent, recording"),
        ('{"limit": 3}', "unknown field `limit`; did you mean limit_ticks? known: maps, seats, limit_ticks, practice"),
        ('{"map": [1]}', "Expected `object | null`, got `array` - at `$.map`"),
        ('{"seats": [{"kind": 3}]}', "Expected `str`, got `int` - at `$.seats[0].kind`"),
        ("[]", "Expected `object`, got `array`"),
        ("{", "Input data was truncated"),
    ],
)
def test_a_wrong_value_or_field_is_answered_with_the_known_ones(body: str, sentence: str) -> None:
    with pytest.raises(msgspec.MsgspecError) as raised:
        msgspec.json.decode(body, type=RoomRequest)
    assert sentence in refusal(raised.value, RoomRequest)
