"""The binary frames against literal bytes (shared with web/tests) and against garbage."""

import json
import math
import struct
from typing import Annotated, Any, ClassVar

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.source import frame_tables
from movingout.server import messages as m
from movingout.server.frame_layout import Form, FrameError, Packed, Wire
from movingout.server.frames import (
    FRAME_FIELDS,
    FRAMES,
    Bundle,
    Input,
    Ping,
    WirePose,
    decode_client_frame,
    decode_poses,
    encode_poses,
)
from movingout.server.messages_js import TARGET, frame_type, generate
from tests.server import golden_frames
from tests.server.support import make_bundle, make_input

GOLDEN = json.loads(golden_frames.FILE.read_text(encoding="utf-8"))


def plain(frame: Packed) -> dict[str, Any]:
    """The fields as values that compare."""
    parts = {name: getattr(frame, name) for name in frame.__struct_fields__}
    return {name: part.tolist() if isinstance(part, np.ndarray) else part for name, part in parts.items()}


@pytest.mark.parametrize("golden", GOLDEN, ids=lambda golden: str(golden["name"]))
def test_frames_have_the_golden_bytes_and_come_back_from_them(golden: dict[str, Any]) -> None:
    frame = golden_frames.from_javascript_names(golden["frame"], golden["value"])
    assert frame.encode().hex() == golden["hex"]
    assert plain(type(frame).decode(bytes.fromhex(golden["hex"]))) == plain(frame)


def test_the_generated_javascript_is_current() -> None:
    assert TARGET.read_text(encoding="utf-8") == generate(), "run: python -m movingout.server.messages_js"


def test_the_golden_frames_are_current() -> None:
    text = golden_frames.FILE.read_text(encoding="utf-8")
    assert text == golden_frames.written(text), "run: make generate"


def test_a_field_that_is_new_is_zero_in_the_golden_frames() -> None:
    without = [golden | {"value": {**golden["value"]}} for golden in GOLDEN]
    del without[-1]["value"]["flags"], without[4]["value"]["seenTick"]
    assert golden_frames.written(json.dumps(without)) == golden_frames.FILE.read_text(encoding="utf-8")


def test_the_tables_of_the_protocol_page_are_current() -> None:
    text = frame_tables.PAGE.read_text(encoding="utf-8")
    assert text == frame_tables.page(text), "run: make generate"


def test_the_welcome_names_every_number_of_every_frame() -> None:
    for name, frame in FRAMES.items():
        fields = FRAME_FIELDS[name]
        numbers = struct.unpack(fields.format, bytes(frame.layout.size))
        assert len(fields.names) == len(set(fields.names)) == len(numbers)
    sent = make_bundle(tick=7, held=(2, -1), poses=np.zeros((5, 3, 3))).encode()
    head = dict(zip(FRAME_FIELDS["bundle"].names, struct.unpack_from(FRAME_FIELDS["bundle"].format, sent), strict=True))
    assert [head[name] for name in ("type", "tick", "held_blue", "held_red", "bodies")] == [m.BUNDLE, 7, 2, -1, 3]


def test_a_declared_field_reaches_the_bytes_the_value_and_the_javascript() -> None:
    class Gust(Packed, frozen=True):
        """Wind."""

        TYPE: ClassVar[int | None] = 9

        force: Annotated[float, Wire("H", "of the wind", scale=m.SLACK_SCALE)]
        from_each: Annotated[tuple[int, int], Wire("b", "where from", form=Form.EACH_SEAT)]

    frame = Gust(force=2.5, from_each=(-1, 3)).encode()
    assert frame.hex() == "09" + "1900" + "ff03"
    assert Gust.decode(frame) == Gust(force=2.5, from_each=(-1, 3))
    script = frame_type(Gust)
    assert "@property {number} force  of the wind" in script
    assert "@property {[number, number]} fromEach  where from" in script


def test_poses_are_packed_in_bulk_as_they_are_declared() -> None:
    poses = np.random.default_rng(0).uniform(-4, 4, (2, 3, 3))
    rows = [WirePose(x=x, y=y, angle=angle).encode() for x, y, angle in poses.reshape(-1, 3).tolist()]
    assert encode_poses(poses) == b"".join(rows)
    first = decode_poses(rows[0], 1, 1)[0, 0]
    assert WirePose.decode(rows[0]) == WirePose(x=first[0], y=first[1], angle=first[2])


def test_positions_beyond_the_wire_are_clipped_and_angles_wrap() -> None:
    poses = np.array([[[9.0, -9.0, 3 * math.pi / 2]]])
    bundle = make_bundle(poses=np.repeat(poses, 2, axis=1))
    x, y, angle = Bundle.decode(bundle.encode()).poses[0, 0]
    assert (round(x, 4), round(y, 4), round(angle, 4)) == (1.6384, -1.6384, -1.5708)


@pytest.mark.parametrize(
    "frame",
    [
        b"",
        bytes([1]),
        bytes([9] * 28),
        make_input().encode()[:-1],
        make_input().encode() + b"x",
        make_input(seat=2).encode(),
        make_input(device=99).encode(),
        make_input(client_ms=math.nan).encode(),
        Ping(client_ms=math.inf).encode(),
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
    assert all(math.isfinite(number) for number in plain(decoded).values())


@given(st.floats(-1, 1), st.floats(-math.pi, math.pi))
def test_an_input_keeps_its_stick_to_the_resolution_of_the_wire(move: float, heading: float) -> None:
    sent = make_input(
        seat=1, seq=7, ack_tick=3, seen_tick=2, move=move, heading=heading, grabs=200, device=1, client_ms=12.5
    )
    got = Input.decode(sent.encode())
    assert abs(got.move - move) <= 1 / 32767
    assert abs(math.remainder(got.heading - heading, 2 * math.pi)) <= math.pi / 32768
    assert plain(got) | {"move": move, "heading": heading} == plain(sent)
