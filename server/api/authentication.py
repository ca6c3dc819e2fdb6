"""Who sends a request and what it contains: address, secret, origin, room, seat, body."""

from collections.abc import Callable
from typing import Any, Concatenate, NamedTuple, TypeVar

import msgspec
from fastapi import Request
from starlette.requests import ClientDisconnect

from movingout.server.api.errors import ApiError
from movingout.server.api.refusals import refusal
from movingout.server.connection.origin import origin_allowed
from movingout.server.notices import Notice
from movingout.server.public_host import Found, Given, NoRoom, PublicHost
from movingout.server.rooms.room import Room

Body = TypeVar("Body")


def admin(host: PublicHost) -> Any:
    """Dependency of routes that are reserved to the operator."""

    async def check(request: Request) -> None:
        token = bearer(request)
        if not token:
            raise ApiError(401, "no_token", "This needs the admin token that was printed when the server started.")
        if not host.is_admin(token):
            if await host.admission.guesses_too_often(address_of(request), "admin"):
                raise ApiError(429, "locked", "Too many wrong keys from your address; wait a minute.")
            raise ApiError(403, "wrong_token", "This is not the admin token that was printed when the server started.")

    return check


def own_page(host: PublicHost) -> Any:
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


class TokenHolder(NamedTuple):
    """Whose token it is."""

    seat: int
    study: bool  # whether the room belongs to a study
    recordings: tuple[str, ...]  # of the rounds that were played in it


async def in_room(
    host: PublicHost,
    room_id: str,
    work: Callable[Concatenate[Room, Given], Found],
    *args: Given.args,
    **kwargs: Given.kwargs,
) -> Found:
    """What `work` finds in the room that a path names. Raises ApiError."""
    try:
        return await host.ask(room_id, work, *args, **kwargs)
    except NoRoom:
        raise _no_room() from None


async def close_room(host: PublicHost, room_id: str, code: int, notice: Notice) -> None:
    """Close the room that a path names. Raises ApiError."""
    try:
        await host.close_room(room_id, code, notice)
    except NoRoom:
        raise _no_room() from None


async def close_rooms_beside(host: PublicHost, room_id: str, code: int, notice: Notice) -> int:
    """Close all rooms of the address that opened this one: how many there were. Raises ApiError."""
    closed = await host.close_rooms_owned_by(host.admission.owner_of(room_id), code, notice)
    if not closed:
        raise _no_room()
    return closed


def _no_room() -> ApiError:
    return ApiError(404, "no_room", "This room no longer exists. Start a new game.")


async def seat_of_token(host: PublicHost, room_id: str, request: Request) -> TokenHolder:
    """The seat whose token came with the request; wrong ones are counted. Raises ApiError."""
    seat, was_theirs = await in_room(host, room_id, _token_holder, bearer(request))
    if seat is None:
        # a page that has rejoined since may still send the token of before, which is no guess
        if not was_theirs and await host.admission.guesses_too_often(address_of(request), "seat"):
            raise ApiError(429, "locked", "Too many wrong keys from your address; wait a minute.")
        raise ApiError(401, "wrong_token", "This seat's key is not valid; reload the page of the game.")
    return seat


def _token_holder(room: Room, token: str) -> tuple[TokenHolder | None, bool]:
    """Whose token it is, and whether it was one of the room's before."""
    seat = room.seating.seat_of_token(token)
    played = tuple(result.recording for result in room.series.results if result.recording)
    holder = None if seat is None else TokenHolder(seat.index, bool(room.config.study), played)
    return holder, room.seating.was_token(token)


async def limit_answers(host: PublicHost, request: Request) -> None:
    """Raises ApiError where the address has answered more than people can: each answer stays on the disk."""
    if not host.admission.may_answer(address_of(request), len(await request.body())):
        raise ApiError(429, "too_many_requests", "Too much was answered from your address; try again later.")


def limit_replays(host: PublicHost, address: str) -> None:
    """Raises ApiError where the address has asked for more recordings than people can look at."""
    if not host.admission.may_replay(address):
        raise ApiError(429, "too_many_replays", "Many recordings were asked for; wait a minute.", retry_s=60)


async def body_of(request: Request, kind: type[Body]) -> Body:
    """The validated body. Raises ApiError."""
    try:
        body: Body = msgspec.json.decode(await request.body(), type=kind)
        return body
    except (msgspec.MsgspecError, RecursionError, UnicodeError) as error:
        raise ApiError(422, "bad_request", f"the request is not understood: {refusal(error, kind)}") from None
    except ClientDisconnect:  # a phone without a network, or who trickled too long: no fault of ours
        raise ApiError(400, "bad_request", "the request ended before it was whole") from None
