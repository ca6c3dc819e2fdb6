"""Every message between server and client, in one closed list per direction.

Subprotocol `movingout.v1`. Control messages are JSON text frames with a `type`; the hot path (bundle, beat,
input, ping, pong) is binary, little endian. `web/messages.js` is generated from this module
(`python -m movingout.server.messages_js`); a test fails when it is stale. docs/protocol.md explains the conversation.
"""

from typing import Annotated, Literal

import msgspec

from movingout.maps import shapes
from movingout.maps.spec import ARENA_HALF as ARENA_HALF
from movingout.maps.spec import ROBOT_RADIUS as ROBOT_RADIUS
from movingout.maps.spec import WALL_MARGIN as WALL_MARGIN
from movingout.server.rooms import time_limits
from movingout.world import constants, ping

SUBPROTOCOL = "movingout.v1"
PROTOCOL = 1

TICK_MS = constants.TICK_MS
POSES_PER_TICK = constants.POSES_PER_TICK
LIMIT_TICKS = constants.LIMIT_TICKS
INVITED_S = time_limits.INVITED_S
PING_TICKS = ping.PING_TICKS

# The rule of world/grab.py, for pages that show what a grab would take [u]; corners of boxes in sides.
REACH = constants.REACH
REACH_TOLERANCE = constants.REACH_TOLERANCE
CORNER_FRACTION = shapes.CORNER_FRACTION

# ---- binary frames: the first byte is the type -------------------------------------------------------------

BUNDLE, BEAT, INPUT, PING, PONG = 1, 2, 3, 4, 5

POSITION_SCALE = 20000.0  # int16 = round(position * scale): 5e-5 units, +-1.638
ANGLE_SCALE = 32768.0 / 3.141592653589793  # int16 wraps with the angle
AXIS_SCALE = 32767.0
SLACK_SCALE = 10.0  # input slack in 0.1 ms

FLAG_NOT_RECORDING = 1
FLAG_SKIPPED = 2  # ticks were skipped before this one

DEVICES = ("keyboard", "gamepad", "touch", "program")
EVENT_CODES = ("grab", "grab_failed", "release", "delivered", "undelivered", "deadline_missed", "agent_error")
EVENT = {name: code for code, name in enumerate(EVENT_CODES)}

# ---- close codes -------------------------------------------------------------------------------------------

CLOSE_RETRY = 4000  # retry now: the room is in another process
CLOSE_RETRY_LATER = 4001  # retry with back-off
CLOSE_KICKED = 4003
CLOSE_REPLACED = 4004  # the seat was taken by a newer socket with the same token
CLOSE_ROOM_OVER = 4005
CLOSE_TOO_SLOW = 4008
# 4009 is reserved: earlier versions declared it
CLOSE_SHUTDOWN = 4010  # the server stops; the room comes back after a restart
CLOSE_BAD_MESSAGE = 4400
CLOSE_UNAUTHORISED = 4401  # wrong token
CLOSE_NOT_FOUND = 4404  # no such room

Phase = Literal["lobby", "countdown", "playing", "paused", "round_over", "series_over", "closed"]
Mode = Literal["play", "watch"]
TutorialStep = Literal["drive", "grab", "deliver", "backward", "lift"]
Kind = Literal["human", "agent", "remote", "ghost", "idle"]

MOST_TOKENS = 4  # of one join: a client has at most two seats, and each token is compared with every key of the room

# ---- client to server --------------------------------------------------------------------------------------


class Join(msgspec.Struct, tag="join", tag_field="type", forbid_unknown_fields=True):
    """The first message of every socket, within 5 s.

    `tokens` are the seat tokens this client already has (a reload, the creator of the room); `claim` is how many
    open seats it wants besides (0-2).
    """

    room: str
    mode: Mode = "play"
    tokens: Annotated[list[str], msgspec.Meta(max_length=MOST_TOKENS)] = []
    claim: Annotated[int, msgspec.Meta(ge=0, le=2)] = 0
    name: str = ""
    program: bool = False  # a remote seat: an external program plays


class Ready(msgspec.Struct, tag="ready", tag_field="type", forbid_unknown_fields=True):
    """Whether the person in `seat` is ready for the coming round."""

    seat: int
    ready: bool = True


class Pause(msgspec.Struct, tag="pause", tag_field="type", forbid_unknown_fields=True):
    """Stop the clock (`resume` is the same button: ready again)."""

    seat: int


class Leave(msgspec.Struct, tag="leave", tag_field="type", forbid_unknown_fields=True):
    """The person in `seat` leaves for good: the episode ends cleanly."""

    seat: int


class Again(msgspec.Struct, tag="again", tag_field="type", forbid_unknown_fields=True):
    """Play the last round's map once more (`Ready` goes on to the next one)."""

    seat: int


class Keyframe(msgspec.Struct, tag="keyframe", tag_field="type", forbid_unknown_fields=True):
    """Please send the whole state."""


class Focus(msgspec.Struct, tag="focus", tag_field="type", forbid_unknown_fields=True):
    """The page is hidden, and its seats go neutral, or visible; sent after each welcome and change, and recorded."""

    visible: bool


class Skip(msgspec.Struct, tag="skip", tag_field="type", forbid_unknown_fields=True):
    """The person in `seat` ends the tutorial early; recorded."""

    seat: int


class SayPing(msgspec.Struct, tag="ping", tag_field="type", forbid_unknown_fields=True):
    """ "Help here", from the person in `seat`: at an item, or at the own place (-1)."""

    seat: int
    item: int = -1


ClientMessage = Join | Ready | Pause | Leave | Again | Keyframe | Focus | Skip | SayPing

# ---- server to client --------------------------------------------------------------------------------------


class SeatState(msgspec.Struct):
    """One seat as everybody in the room may see it."""

    colour: str  # blue, red
    kind: Kind
    name: str  # "Partner A", "scripted", a nickname
    open: bool  # still to be claimed by somebody with the link
    present: bool
    ready: bool
    device: str = ""
    rtt_ms: float = -1.0
    visible: bool = True  # the page, as far as it has told


class SeatGrant(msgspec.Struct):
    """A seat of this client with its token: keep it for reloads; it changes at each join."""

    seat: int
    token: str


class FrameFields(msgspec.Struct):
    """A binary frame, so that a program can read and write it by name."""

    format: str  # of Python's struct
    names: list[str]  # of its numbers; `docs/protocol.md` says what they mean


class Welcome(msgspec.Struct, tag="welcome", tag_field="type"):
    """The answer to `Join`."""

    protocol: int
    build: str
    room: str
    mode: Mode
    seats: list[SeatGrant]
    resume_s: float
    join_path: str
    watch_path: str
    study: bool = False  # a round of a study: the page goes back to /study when it is over
    pings: bool = False  # whether `SayPing` is possible here
    frames: dict[str, FrameFields] = {}


class Round(msgspec.Struct, tag="round", tag_field="type"):
    """The coming or running round: bodies are the two robots, then `map.items` in order."""

    index: int  # from 0
    total: int
    epoch: int
    map: dict[str, object]  # our map JSON
    limit_ticks: int  # 0: no limit (practice)
    practice: bool
    episode: str


class RoomState(msgspec.Struct, tag="room", tag_field="type"):
    """Phase and seats, on every change and once a second."""

    phase: Phase
    reason: str  # one sentence in English, may be empty
    until_ms: float  # server time at which countdown or pause ends, 0 for none
    seats: list[SeatState]
    spectators: int
    recording: bool
    reason_code: str = ""  # what `reason` says, for pages in other languages
    reason_values: dict[str, object] = {}


class FullState(msgspec.Struct, tag="keyframe", tag_field="type"):
    """The whole state after `tick` at server time `time_ms`."""

    epoch: int
    tick: int
    time_ms: float
    poses: list[list[float]]  # bodies x (x, y, angle)
    held: list[int]
    delivered: list[bool]


class Tutorial(msgspec.Struct, tag="tutorial", tag_field="type"):
    """Where a tutorial is: sent after `Round`, and whenever a step or a seat's part in it is done."""

    step: TutorialStep  # the last one stays when all are done
    number: int  # of the step, from 1
    total: int
    finished: bool  # all steps are done
    done: list[bool]  # per seat: it has done its part of this step; agents have
    rings: list[list[float]]  # per seat: x, y, radius of the ring to drive to; empty for none
    targets: list[int]  # per seat: the item to grab, -1 for none


class Result(msgspec.Struct, tag="result", tag_field="type"):
    """How a round ended."""

    index: int
    outcome: str  # delivered | time | left | stopped | error
    ticks: int
    delivered: int
    items: int
    tcr: float
    nfd: float
    wt_s: float
    ac: float  # NaN never: -1 when nobody carried together
    recording: str  # episode id, empty when not recorded
    metrics: dict[str, float] = {}  # all of world/metrics.py by key, those above included; -1 for none
    delivered_by: list[list[int]] = []  # per item the seats that brought it home; empty lists for the others


class Problem(msgspec.Struct, tag="error", tag_field="type"):
    """Something this client asked for cannot be done; the socket stays open."""

    code: str
    message: str  # in English
    values: dict[str, object] = {}  # what the message tells besides its code, by name


class Bye(msgspec.Struct, tag="bye", tag_field="type"):
    """The last message before the server closes with `code`."""

    code: int
    message: str  # in English
    error: str = ""  # the code of the message, for pages in other languages
    values: dict[str, object] = {}


class ShownPing(msgspec.Struct, tag="ping", tag_field="type"):
    """A seat asks for help: to be shown for `ticks` ticks."""

    epoch: int
    tick: int  # the one that follows it
    seat: int
    item: int  # -1: at the place of the robot
    x: float  # where that was
    y: float
    ticks: int


ServerMessage = Welcome | Round | RoomState | FullState | Tutorial | Result | Problem | Bye | ShownPing
