"""The HTTP API of maps: those that are offered, and the checks and trials of the editor."""

from typing import Any

import msgspec
import orjson
from fastapi import APIRouter, Depends, Request
from fastapi.responses import Response

from movingout.maps import PRACTICE, MapSpec, MovingOutError, is_reserved, load_map, map_to_json, shipped_map_names
from movingout.maps.check import MapFault
from movingout.maps.generated.proved import proved_maps
from movingout.server.api import pages
from movingout.server.api.authentication import address_of, body_of, own_page
from movingout.server.api.errors import ApiError
from movingout.server.api.named_maps import named_map
from movingout.server.connection.admission import address_group
from movingout.server.own_maps.folder import MapFolder
from movingout.server.own_maps.solving import Checked, TooSlow
from movingout.server.own_maps.workers import Busy
from movingout.server.public_host import PublicHost


class DrawnMap(msgspec.Struct, forbid_unknown_fields=True):
    """The body of the editor's requests: a JSON document, whatever it contains."""

    map: Any


class OfferedMaps:
    """All maps as one JSON document, made anew only when the operator's have changed: 200 of them take long enough to
    delay ticks, and every lobby asks for it."""

    def __init__(self, own: MapFolder) -> None:
        self._own = own
        self._made_of: tuple[dict[str, MapSpec], int] | None = None
        self._document = b""

    def document(self) -> bytes:
        own = self._own
        if self._made_of != (own.maps, len(own.problems)):
            self._made_of = own.maps, len(own.problems)
            maps = {
                "maps": [map_to_json(load_map(name)) for name in shipped_map_names() if name != PRACTICE],
                "practice": map_to_json(load_map(PRACTICE)),
                "own": [map_to_json(spec) for spec in own.maps.values()],
                "own_left_out": len(own.problems),
                "surprise": proved_maps("validation"),  # not test: recordings of players may be trained on
            }
            self._document = orjson.dumps(maps)
        return self._document


def map_routes(host: PublicHost) -> APIRouter:
    """`/api/maps`, and the editor's requests where anybody may open rooms."""
    router = APIRouter()
    offered = OfferedMaps(host.own_maps)

    @router.get("/api/maps")
    async def maps() -> Response:
        await host.own_maps.refresh(host.map_workers.read_file)
        return Response(offered.document(), media_type="application/json")

    @router.get("/api/maps/{name:path}")  # a name may have a slash; then it is no map, which is said
    async def one_map(name: str, request: Request) -> dict[str, Any]:
        """A map that no list has, as HandOff:mirror or a generated one."""
        if not host.admission.may_check_map(address_of(request)):
            raise ApiError(429, "map_busy", "Too many maps were checked from your address; wait a few seconds.")
        return map_to_json(await named_map(host, name, address_of(request)))

    if host.settings.lobby:
        router.include_router(_editor_routes(host))

        @router.get("/editor")
        async def editor() -> Response:
            return pages.page("editor/editor.html")

    return router


def _editor_routes(host: PublicHost) -> APIRouter:
    router = APIRouter(prefix="/api/editor", dependencies=[Depends(own_page(host))])

    @router.post("/check")
    async def check(request: Request) -> dict[str, Any]:
        if not host.admission.may_check_map(address_of(request)):
            raise ApiError(429, "map_busy", "Too many maps were checked from your address; wait a few seconds.")
        document = (await body_of(request, DrawnMap)).map
        spec, faults, hints = await _checked(host, document, address_of(request))
        if spec is not None and is_reserved(spec.name):
            faults = (*faults, _taken_name(spec.name))
            hints = tuple(hint for hint in hints if hint.path != "name")
        found, hinted = ([_fault_json(one) for one in ones] for ones in (faults, hints))
        return {"map": None if spec is None else map_to_json(spec), "faults": found, "hints": hinted}

    @router.post("/solve")
    async def solve(request: Request) -> dict[str, Any]:
        address = address_of(request)
        if not host.admission.may_solve_map(address):
            raise ApiError(429, "map_busy", "Too many maps were solved from your address; wait a minute.")
        document = (await body_of(request, DrawnMap)).map
        spec = await playable(host, document, address, own_name=False)
        try:
            return await host.map_workers.solve(spec, address_group(address))
        except Busy as error:
            raise ApiError(503, "map_busy", str(error)) from None
        except TooSlow as error:
            raise ApiError(422, "map_slow", f"The scripted pair did not get through: {error}.") from None
        except MovingOutError as error:
            raise ApiError(422, "map_unsolved", f"The scripted pair cannot play this map: {error}.") from None

    return router


async def playable(host: PublicHost, document: object, address: str, own_name: bool = True) -> MapSpec:
    """The map of a drawn document. Raises ApiError with its first fault; with `own_name`, also for a shipped name."""
    spec, faults, _ = await _checked(host, document, address)
    if spec is None or faults:
        raise ApiError(422, "map_faulty", f"This map cannot be played: {faults[0]}.", path=faults[0].path)
    if own_name and is_reserved(spec.name):
        raise ApiError(422, "map_name", f"{spec.name} is the name of a shipped map; choose another.", name=spec.name)
    return spec


async def _checked(host: PublicHost, document: object, address: str) -> Checked:
    try:
        return await host.map_workers.check(document, address_group(address))
    except Busy as error:
        raise ApiError(503, "map_busy", str(error)) from None
    except TooSlow as error:
        raise ApiError(422, "map_slow", f"This map could not be checked: {error}.") from None
    except RecursionError:  # as `body_of`, which reads a little more than can be sent to another process
        raise ApiError(422, "bad_request", "the request is not understood: it is nested too deeply") from None


def _taken_name(name: str) -> MapFault:
    return MapFault("name", f"{name} is the name of a shipped map; choose another", "name_taken", {"name": name})


def _fault_json(fault: MapFault) -> dict[str, Any]:
    return {"path": fault.path, "message": fault.message, "code": fault.code, "values": dict(fault.values)}
