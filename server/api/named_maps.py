"""Maps by the names under which rooms and pages ask for them."""

from movingout.maps import MapSpec, MovingOutError, is_shipped, load_map, shipped_map_names
from movingout.maps.generated.names import is_generated
from movingout.maps.suggestion import known_names, shortened
from movingout.maps.symmetry import SEPARATOR, SYMMETRY_NAMES
from movingout.server.api.errors import ApiError
from movingout.server.connection.admission import address_group
from movingout.server.own_maps.workers import Busy
from movingout.server.public_host import PublicHost


async def named_map(host: PublicHost, name: str, address: str) -> MapSpec:
    """Any map that a room can be opened on by its name. Raises ApiError for a name that is no map."""
    if is_shipped(name):
        return load_map(name)
    spec = await own_map(host, name, address)
    if spec is None:
        raise unknown_map(host, name)
    return spec


async def own_map(host: PublicHost, name: str, address: str) -> MapSpec | None:
    """A map of the operator's folder, or a generated one, which is made where it delays no tick. Raises ApiError."""
    if not is_generated(name):
        return host.own_maps.find(name)
    try:
        return await host.map_workers.generate(name, address_group(address))
    except Busy as error:
        raise ApiError(503, "map_busy", str(error)) from None
    except MovingOutError as error:
        raise ApiError(422, "unknown_map", str(error), map=shortened(name)) from None


def unknown_map(host: PublicHost, name: str) -> ApiError:
    """Says which map or symmetry was probably meant."""
    known = [*shipped_map_names(), *host.own_maps.maps]
    name = shortened(name)
    base, _, symmetry = name.partition(SEPARATOR)
    if base in known:
        text = f"unknown symmetry {symmetry!r} of {base}; {known_names(symmetry, SYMMETRY_NAMES)}"
    else:
        text = f"unknown map {name!r}; {known_names(name, known)}"
    return ApiError(422, "unknown_map", text, map=name)
