"""The binary frames against literal bytes (shared with web/tests) and against garbage."""

import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from movingout.server.frames import Beat, Bundle, BundleEvent, FrameError, Input, Ping, Pong, decode_client_frame
from movingout.server.messages_js import TARGET, generate

GOLDEN = json.loads((Path(__file__).parent / "golden_frames.json").read_text())
Frame = Beat | Bundle | Input | Ping | Pong
FRAMES: dict[str, type[Any]] = {"Beat": Beat, "Input": Input, "Ping": Ping, "Pong": Pong}


def from_javascript_names(kind: str, value: dict[str, Any]) -> Frame:
    fields = {re.sub(r"([A-Z])", lambda hit: "_" + hit[1].lower(), name): part for name, part in value.items()}
    if kind == "Bundle":
        poses = np.array(fields.pop("poses")).reshape(fields.pop("pose_count"), fields.pop("bodies"), 3)
        fields = {name: tuple(part) if isinstance(part, list) else part for name, part in fields.items()}
        fields["events"] = tuple(BundleEvent(**event) for event in fields["events"])
        return Bundle(**fields, poses=poses)
    frame: Frame = FRAMES[kind](**fields)
    return frame


def plain(frame: Frame) -> list[Any]:
    """The fields as values that compare."""
    return [part.tolist() if isinstance(part, np.ndarray) else part for part in frame]


@pytest.mark.parametrize("golden", GOLDEN, ids=lambda golden: str(golden["name"]))
def test_frames_have_the_golden_bytes_and_come_back_from_them(golden: dict[str, Any]) -> None:
    frame = from_javascript_names(golden["frame"], golden["value"])
    assert frame.encode().hex() == golden["hex"]
    assert plain(type(frame).decode(bytes.fromhex(golden["hex"]))) == plain(frame)


def test_the_generated_javascript_is_current() -> None:
    assert TARGET.read_text(encoding="utf-8") == generate(), "run: python -m movingout.server.messages_js"


def test_positions_beyond_the_wire_are_clipped_and_angles_wrap() -> None:
    poses = np.array([[[9.0, -9.0, 3 * math.pi / 2]]])
    bundle = Bundle(0, 0, 1, 0.0, (0, 0), (0.0, 0.0), (-1, -1), (), np.repeat(poses, 2, axis=1))
    x, y, angle = Bundle.decode(bundle.encode()).poses[0, 0]
    assert (round(x, 4), round(y, 4), round(angle, 4)) == (1.6384, -1.6384, -1.5708)


@pytest.mark.parametrize(
    "frame",
    [
        b"",
        bytes([1]),
        bytes([9] * 28),
        Input(0, 1, 0, 0, 0.0, 0.0, 0, 0, 0.0).encode()[:-1],
        Input(0, 1, 0, 0, 0.0, 0.0, 0, 0, 0.0).encode() + b"x",
        Input(2, 1, 0, 0, 0.0, 0.0, 0, 0, 0.0).encode(),
        Input(0, 1, 0, 0, 0.0, 0.0, 0, 99, 0.0).encode(),
        Input(0, 1, 0, 0, 0.0, 0.0, 0, 0, math.nan).encode(),
        Ping(math.inf).encode(),
    ],
    ids=["empty", "server frame", "unknown", "short", "long", "no such seat", "no such device", "nan", "inf"],
)
def test_what_no_client_sends_is_refused(frame: bytes) -> None:
    with pytest.raises(FrameError):
        decode_client_frame(frame)


@given(st.binary(max_size=64))
def test_random_bytes_are_decoded_or_refused(frame: bytes) -> None:
    try:
        decoded = decode_client_frame(frame)
    except FrameError:
        return
    assert all(math.isfinite(number) for number in decoded)


@given(st.floats(-1, 1), st.floats(-math.pi, math.pi))
def test_an_input_keeps_its_stick_to_the_resolution_of_the_wire(move: float, heading: float) -> None:
    sent = Input(1, 7, 3, 2, move, heading, 200, 1, 12.5)
    got = Input.decode(sent.encode())
    assert abs(got.move - move) <= 1 / 32767
    assert abs(math.remainder(got.heading - heading, 2 * math.pi)) <= math.pi / 32768
    assert got._replace(move=0.0, heading=0.0) == sent._replace(move=0.0, heading=0.0)
