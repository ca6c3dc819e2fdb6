"""Who sends a request and what it contains: address, secret, origin, room, seat, body."""

from typing import Any, TypeVar

import msgspec
from fastapi import Request

from movingout.server.api.errors import ApiError
from movingout.server.connection.origin import origin_allowed
from movingout.server.host import Host
from movingout.server.rooms.room import Room
from movingout.server.rooms.seat import Seat

Body = TypeVar("Body")


def admin(host: Host) -> Any:
    """Dependency of routes that are reserved to the operator."""

    async def check(request: Request) -> None:
        token = bearer(request)
        if not token:
            raise ApiError(401, "no_token", "This needs the admin token that was printed when the server started.")
        if not host.is_admin(token):
            if host.admission.guesses_too_often(address_of(request), "admin"):
                raise ApiError(429, "locked", "Too many wrong keys from your address; wait a minute.")
            raise ApiError(403, "wrong_token", "This is not the admin token that was printed when the server started.")

    return check


def own_page(host: Host) -> Any:
    """Dependency of routes that pages of other origins may not use."""

    async def check(request: Request) -> None:
        if not origin_allowed(request.scope["headers"], request.url.scheme, host.settings.origins):
            raise ApiError(403, "origin", "This page may not talk to this server.")

    return check


def bearer(request: Request) -> str:
    """The secret of a request, empty for none."""
    scheme, _, token = request.headers.get("authorization", "").partition(" ")
    return token.strip() if scheme.lower() == "bearer" else ""


def address_of(request: Request) -> str:
    return request.client.host if request.client else ""


def room_of(host: Host, room_id: str) -> Room:
    """The room that a path names. Raises ApiError."""
    room = host.registry.rooms.get(room_id)
    if room is None:
        raise ApiError(404, "no_room", "This room no longer exists. Start a new game.")
    return room


def seat_of_token(host: Host, room_id: str, request: Request) -> Seat:
    """The seat whose token came with the request; wrong ones are counted. Raises ApiError."""
    seat = room_of(host, room_id).seating.seat_of_token(bearer(request))
    if seat is None:
        if host.admission.guesses_too_often(address_of(request), "seat"):
            raise ApiError(429, "locked", "Too many wrong keys from your address; wait a minute.")
        raise ApiError(401, "wrong_token", "This seat's key is not valid; reload the page of the game.")
    return seat


async def body_of(request: Request, kind: type[Body]) -> Body:
    """The validated body. Raises ApiError."""
    try:
        body: Body = msgspec.json.decode(await request.body(), type=kind)
        return body
    except (msgspec.MsgspecError, RecursionError, UnicodeError) as error:
        raise ApiError(422, "bad_request", f"the request is not understood: {error}") from None
