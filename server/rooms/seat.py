"""The seats of a room: who may take them, and who plays in them.

A seat belongs to the holder of its token. The token changes at each join; the previous one stays valid until the client
has proved that the new one arrived, so that a connection lost in between locks nobody out.
"""

import unicodedata
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Protocol

from movingout.agents.checkpoint.checkpoint import fingerprint
from movingout.maps import MapSpec
from movingout.maps.spec import SEAT_COLOURS
from movingout.recordings import SeatInfo
from movingout.recordings.episode import ActionSource
from movingout.recordings.recorded_seat import ghost_name
from movingout.server.agent_workers.agent_seat import AgentAnswer
from movingout.server.connection.token_bucket import TokenBucket
from movingout.server.messages import Kind, SeatState, ServerMessage
from movingout.server.notices import Notice
from movingout.server.rooms.input_buffer import InputBuffer, TickInput
from movingout.server.rooms.time_limits import CHANGES_BURST, CHANGES_PER_S
from movingout.server.security.tokens import Hash, hash_token, token_matches
from movingout.world.ping import HelpPing
from movingout.world.state import WorldState

NAME_LENGTH = 24


class ClientHandle(Protocol):
    """A connected client, as rooms use it. No method waits."""

    rtt_ms: float  # -1 unknown

    def tell(self, message: ServerMessage, text: str = "") -> None:
        """Queue a control message; `text` is its JSON if the caller has it already."""

    def show(self, tick: int, frame: bytes, now: float) -> None:
        """Send a bundle; a client that does not keep up gets only the newest."""

    def beat(self, frame: bytes) -> None: ...

    def acknowledge(self, tick: int, now: float) -> bool:
        """The newest tick that the client has received; True when it has caught up and needs the whole state."""

    def dismiss(self, code: int, notice: Notice) -> None:
        """Close the connection with a message."""


class AgentPlayer(Protocol):
    """An agent in a seat for one episode (server.agent_workers.agent_seat.AgentSeat)."""

    ready: bool
    failed: str
    slow: bool  # whether it failed because it decides too slowly here
    unseen: str  # a sentence if it was not trained on this map

    def observe(self, state: WorldState, tick: int, deadline: float, pings: tuple[HelpPing, ...] = ()) -> None: ...

    def answer(self, tick: int) -> AgentAnswer: ...

    def close(self) -> None: ...


class AgentSource(Protocol):
    """Where agents come from (server.agent_workers.pool.AgentPool)."""

    def open(self, agent_id: str, map: MapSpec, seat: int, seed: int, ticks: int) -> AgentPlayer: ...


@dataclass
class Seat:
    """One seat. Anybody with the link may take a `shared` seat; the others need a token."""

    index: int
    kind: Kind
    agent_id: str = ""
    shared: bool = False
    name: str = ""
    alias: str = ""  # the pseudonym in recordings; of a ghost, whose seat it was
    token: Hash | None = None
    previous_token: Hash | None = None
    superseded: deque[Hash] = field(default_factory=lambda: deque(maxlen=4))  # no longer valid, but no guesses either
    key: Hash | None = None  # a token that stays valid: the page of a study sends it at each join
    client: ClientHandle | None = None
    ready: bool = False
    wants_again: bool = False
    visible: bool = True  # the page, as far as it has told
    absent_since: float = 0.0
    gone: bool = False  # left for good
    controls: InputBuffer = field(default_factory=InputBuffer)
    player: AgentPlayer | None = None
    changes: TokenBucket = field(default_factory=lambda: TokenBucket(CHANGES_PER_S, CHANGES_BURST, 0.0))

    @property
    def colour(self) -> str:
        return SEAT_COLOURS[self.index]

    @property
    def title(self) -> str:
        """What to call this seat in an English sentence."""
        return self.name or self.colour.capitalize()

    @property
    def player_name(self) -> str:
        """The same for pages, which know their own words for colours: "blue" where nobody has a name."""
        return self.name or self.colour

    @property
    def taken_by_client(self) -> bool:
        """Whether a person or an external program plays here."""
        return self.kind in ("human", "remote")

    @property
    def open(self) -> bool:
        return self.shared and self.token is None and not self.gone

    @property
    def present(self) -> bool:
        return self.client is not None if self.taken_by_client else True

    @property
    def is_ready(self) -> bool:
        if self.taken_by_client:
            return self.ready and self.present
        return self.player is None or self.player.ready or bool(self.player.failed)

    @property
    def agent_failure(self) -> str:
        """Why the agent cannot play, empty if it can."""
        failed = self.player.failed if self.player is not None else ""
        return f"{self.title} cannot play: {failed}." if failed else ""

    @property
    def agent_too_slow(self) -> bool:
        """Whether the agent cannot play because it decides too slowly on this machine."""
        return self.player is not None and bool(self.player.failed) and self.player.slow

    @property
    def agent_caution(self) -> str:
        """Why the agent may play badly on this map, empty if there is no reason."""
        return self.player.unseen if self.player is not None else ""

    # ---- tokens ---------------------------------------------------------------------------------------------

    def knows(self, token: str) -> bool:
        kept = [each for each in (self.token, self.previous_token, self.key) if each is not None]
        return any([token_matches(token, each) for each in kept])

    def knew(self, token: str) -> bool:
        """Whether it is or was a token of this seat, as far as they are remembered."""
        return self.knows(token) or any([token_matches(token, each) for each in self.superseded])

    def sit(self, client: ClientHandle, token: str, name: str, shown: Iterable[str] = ()) -> None:
        """A client that has `shown` these tokens takes the seat, or takes it again; `token` is its new one.

        Who shows the previous token alone never got the newest: the previous one stays valid, however often a line
        drops before the welcome.
        """
        newest_is_lost = self._shows(self.previous_token, shown) and not self._shows(self.token, shown)
        superseded = self.token if newest_is_lost else self.previous_token
        if superseded is not None:
            self.superseded.append(superseded)
        if not newest_is_lost:
            self.previous_token = self.token
        self.token = hash_token(token)
        self.client, self.visible = client, True
        self.controls = InputBuffer()
        self.name = clean_name(name) or self.name

    @staticmethod
    def _shows(kept: Hash | None, shown: Iterable[str]) -> bool:
        return kept is not None and any([token_matches(token, kept) for token in shown])

    def confirm(self) -> None:
        """The client has the new token: the previous one becomes invalid."""
        if self.previous_token is not None:
            self.superseded.append(self.previous_token)
        self.previous_token = None

    def vacate(self) -> None:
        """The player has left; a shared seat may be taken again."""
        self.client, self.ready, self.wants_again, self.visible = None, False, False, True
        self.token = self.previous_token = None
        self.name = self.alias = ""

    def retire(self) -> None:
        """The player has left for good, and nobody takes the seat again."""
        self.vacate()
        self.kind, self.key = "idle", None

    # ---- play -----------------------------------------------------------------------------------------------

    @property
    def rtt_ms(self) -> float:
        """The round trip of this seat's client, -1 if unknown."""
        return self.client.rtt_ms if self.client is not None else -1.0

    def show(self, visible: bool) -> None:
        """The page is visible, or hidden: then nobody holds its controls."""
        self.visible = visible
        if not visible:
            self.controls.release()

    def source(self, tick_input: TickInput) -> ActionSource:
        """Who chose the action, for the recording."""
        return self.kind if tick_input.fresh or self.kind == "idle" else "neutral"

    def close_player(self) -> None:
        if self.player is not None:
            self.player.close()
            self.player = None

    # ---- views ----------------------------------------------------------------------------------------------

    def view(self) -> SeatState:
        device = self.controls.device if self.taken_by_client else ""
        return SeatState(
            colour=self.colour,
            kind=self.kind,
            name=self.name,
            open=self.open,
            present=self.present,
            ready=self.is_ready,
            device=device,
            rtt_ms=round(self.rtt_ms, 1),
            visible=self.visible,
        )

    def info(self) -> SeatInfo:
        """The seat in the recording's header: a pseudonym for people, the id for agents."""
        if self.kind == "ghost":
            return SeatInfo(self.kind, self.alias or ghost_name(self.agent_id))  # rooms of before were saved without
        if self.kind == "agent":
            return SeatInfo(self.kind, self.agent_id, fingerprint(self.agent_id))
        if not self.taken_by_client:
            return SeatInfo(self.kind, "idle")
        return SeatInfo(self.kind, self.alias, device=self.controls.device)


def clean_name(name: str) -> str:
    """A nickname without control characters, at most NAME_LENGTH letters."""
    printable = "".join(letter for letter in name if unicodedata.category(letter)[0] not in "CZ" or letter == " ")
    return " ".join(printable.split())[:NAME_LENGTH]
