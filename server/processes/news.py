"""What a process with rooms tells the front: each function is done there, by the `RoomLink` of that process."""

from pathlib import Path
from typing import Protocol

from movingout.server.connection.admission import SocketNews
from movingout.server.monitoring.overload import ProcessHealth
from movingout.server.rooms.room_view import PlayedRound


class Listener(Protocol):
    """Who hears of one process with rooms."""

    def became_ready(self, owners: dict[str, str]) -> None:
        """It can be reached, and has these rooms: the owner of each by its id."""

    def leaving(self) -> None:
        """It ends, and takes no more connections."""

    def heard(self, health: ProcessHealth) -> None:
        """It lives, and is as it says."""

    def arrived(self, address: str) -> None:
        """A websocket over TLS from this address has been opened there."""

    def socket_changed(self, news: SocketNews, address: str) -> None:
        """A websocket from this address has entered, joined a room, left or flooded."""

    def room_closed(self, room_id: str) -> None: ...

    def recorded(self, room_id: str, size: int) -> None:
        """A round has taken so many bytes."""

    def round_over(self, room_id: str, played: PlayedRound) -> None:
        """A round of a study is over."""

    def finish_journal(self, journal: Path) -> None:
        """A round is over: its journal is to become a recording."""


def became_ready(listener: Listener, owners: dict[str, str]) -> None:
    listener.became_ready(owners)


def leaving(listener: Listener) -> None:
    listener.leaving()


def heard(listener: Listener, health: ProcessHealth) -> None:
    listener.heard(health)


def recorded(listener: Listener, room_id: str, size: int) -> None:
    listener.recorded(room_id, size)


def arrived(listener: Listener, address: str) -> None:
    listener.arrived(address)


def socket_changed(listener: Listener, news: SocketNews, address: str) -> None:
    listener.socket_changed(news, address)


def room_closed(listener: Listener, room_id: str) -> None:
    listener.room_closed(room_id)


def round_over(listener: Listener, room_id: str, played: PlayedRound) -> None:
    listener.round_over(room_id, played)


def finish_journal(listener: Listener, journal: Path) -> None:
    listener.finish_journal(journal)
