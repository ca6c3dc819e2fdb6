"""What the server tells people: a code, by which a page finds the text in its reader's language, and values for it.

Every code has a text in each web/words/<language>.json, as `error.<code>`, `reason.<code>`, `refusal.<code>`,
`alert.<code>` or `unrecorded.<code>`. The English message beside it is for programs and logs, and for pages that do
not know the code.
"""

from typing import Any, Literal

import msgspec

ErrorCode = Literal[
    # any request
    "fault", "bad_request", "too_large", "not_found", "origin", "locked", "too_many_requests", "no_token",
    "wrong_token", "full",
    # rooms
    "no_room", "too_many_rooms", "rooms_unjoined", "rooms_open", "recorded_today", "study", "unknown_map", "maps",
    "seats", "seat_kind", "limit_ticks", "challenge2_seed",
    "unknown_agent", "damaged_agent", "agent_map", "agent_options", "no_agent", "ghost", "blinded", "tutorial",
    "agents_only", "too_many_agents",
    # maps of one's own
    "map_faulty", "map_name", "map_busy", "map_slow", "map_unsolved", "map_variant",
    # seats
    "room_full", "watchers_full", "not_your_seat", "wrong_phase", "joined", "no_tutorial",
    "pings_off", "ping_rate", "ping_item", "ready_rate", "pauses_used",
    # why a connection or a room is closed
    "replaced", "nobody_here", "room_idle", "room_failed", "closed_by_operator", "restarting", "moving", "room_waits",
    "room_kept", "too_slow", "connection_failed",
    "round_over", "round_restarted", "practice_over", "participant_left",
    # answers and recordings
    "answer", "not_saved", "no_recording", "no_recordings", "readers_busy", "too_many_pictures", "too_many_replays",
    "no_finding", "annotator",
    # participants of a study
    "elsewhere", "no_participant", "link", "preview", "code", "code_used", "code_unknown", "study_full", "boxes",
    "slow", "gamepad", "keep", "step", "unanswered", "too_many_arrivals", "link_expired", "other_device",
    "partner_came",
]  # fmt: skip
ReasonCode = Literal[
    "restarted", "restarted_anew", "lost", "waiting", "paused", "all_back", "not_back", "unsteady", "paused_too_long",
    "left", "seat_free", "simulation_failed", "agent_failed", "agent_slow", "agent_unseen", "cannot_start",
    "study_paused", "restart_soon",
]  # fmt: skip
RefusalCode = Literal["restarting", "rooms_in_use", "busy", "disk_full"]  # why no room can be opened now
UnrecordedCode = Literal["disk_full", "not_writable", "failed"]  # why a round is not recorded
AlertCode = Literal[
    "fault", "disk", "database", "deletion", "recovery", "not_closed", "recording", "room", "agent_failed",
    "agent_unseen", "gone", "slow", "duplicate", "controls", "full", "away",
    "other_device", "server", "unvaried", "clock",
]  # fmt: skip

NoticeCode = ErrorCode | ReasonCode | RefusalCode | UnrecordedCode | Literal[""]


class Notice(msgspec.Struct, frozen=True):
    """One sentence to people. In `values`, `players` is a list of names, or of colours where nobody has a name."""

    code: NoticeCode = ""
    message: str = ""  # in English
    values: dict[str, Any] = {}

    def __bool__(self) -> bool:
        """Whether anything is said."""
        return self.message != ""


NOTHING = Notice()
