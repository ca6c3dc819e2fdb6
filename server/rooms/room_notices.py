"""What a room tells its people about itself, as codes and values."""

import errno
import logging
from collections.abc import Sequence
from typing import NamedTuple

from movingout.recordings import RecordingError
from movingout.server.messages import Phase
from movingout.server.notices import NOTHING, ErrorCode, Notice, ReasonCode
from movingout.server.rooms.seat import Seat
from movingout.server.rooms.time_limits import INVITED_S
from movingout.world.constants import TICK_SECONDS

log = logging.getLogger(__name__)

RESTARTED = Notice("restarted_anew", "The server was restarted; this round starts again.")
RESTARTING = Notice("restarting", "The server is being restarted; this page comes back by itself.")
RESTART_SOON = Notice("restart_soon", "The server restarts in a moment; the next round begins after that.")
REPLACED = Notice("replaced", "This seat is now played from another window.")
NOBODY_HERE = Notice("nobody_here", "Nobody was here for a while.")
ROOM_IDLE = Notice("room_idle", "Nothing happened here for a while, and others needed the room.")
NO_SPACE = (errno.ENOSPC, errno.EDQUOT)


class OpeningRefused(NamedTuple):
    """Why an address may open no further room, as in `Notice`."""

    code: ErrorCode
    message: str
    values: dict[str, int]


TOO_MANY_ROOMS = OpeningRefused("too_many_rooms", "Too many rooms were opened from your address; wait a minute.", {})
RECORDED_TODAY = OpeningRefused(
    "recorded_today", "Games from your address have recorded as much as they may in a day; try again later.", {}
)


def rooms_unjoined(most: int) -> OpeningRefused:
    """An address has so many rooms that nobody has joined; after INVITED_S they are closed."""
    minutes = round(INVITED_S / 60.0)
    text = f"{most} rooms opened from your address wait for their first player; join one, or wait {minutes} minutes."
    return OpeningRefused("rooms_unjoined", text, {"count": most, "minutes": minutes})


def rooms_open(most: int) -> OpeningRefused:
    """An address has so many rooms that are in use."""
    text = f"{most} rooms opened from your address are in use; try again when one has been empty for a minute."
    return OpeningRefused("rooms_open", text, {"count": most})


def about(code: ReasonCode, seats: Sequence[Seat], predicate: str) -> Notice:
    """A sentence with these seats as its subject."""
    subject = " and ".join(seat.title for seat in seats)
    return Notice(code, f"{subject} {predicate}", {"players": _names(seats)})


def agent_notice(seats: Sequence[Seat], with_cautions: bool) -> Notice:
    """Which agents cannot play and, where people may be told, whether they are too slow and which may play badly."""
    failed = [seat for seat in seats if seat.agent_failure]
    unseen = [seat for seat in seats if seat.agent_caution and with_cautions]
    message = " ".join([seat.agent_failure for seat in failed] + [seat.agent_caution for seat in unseen])
    if failed:
        log.warning("%s", message)
        slow = with_cautions and all(seat.agent_too_slow for seat in failed)
        return Notice("agent_slow" if slow else "agent_failed", message, {"players": _names(failed)})
    return Notice("agent_unseen", message, {"players": _names(unseen)}) if unseen else NOTHING


def told(phase: Phase, notice: Notice, held_next: Notice, seats: Sequence[Seat]) -> Notice:
    """Why the room is in its phase, or why no further round begins, where one would follow or is asked for."""
    follows = phase in ("lobby", "round_over")
    asked = phase == "series_over" and any(seat.wants_again for seat in seats)
    return held_next if held_next and (follows or asked) else notice


def reason(notice: Notice, study: bool) -> str:
    """The sentence of a notice; a participant of a study must not read which agent the partner is, or its files."""
    if study and notice.code == "agent_failed":
        return f"{' and '.join(notice.values['players'])} cannot play."
    if study and notice.code == "cannot_start":
        return "This round cannot start."
    return notice.message


def resumed(tick: int) -> Notice:
    """The round goes on where its recording ends: a disk that was full may have ended it earlier than the game."""
    seconds = round(tick * TICK_SECONDS)
    return Notice("restarted", f"The server was restarted. The game waits, at second {seconds}.", {"seconds": seconds})


def recording_problem(error: RecordingError) -> Notice:
    """Why a round is not recorded; the message names the file and what would help."""
    cause = error.__cause__
    if isinstance(cause, OSError):
        return Notice("disk_full" if cause.errno in NO_SPACE else "not_writable", str(error))
    return Notice("failed", str(error))


def _names(seats: Sequence[Seat]) -> list[str]:
    return [seat.player_name for seat in seats]
