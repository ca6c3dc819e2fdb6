"""What the agent service tells processes with rooms, besides the answers of its workers."""

import msgspec

from movingout.agents.worker.messages import FromWorker


class Lost(msgspec.Struct, tag=True, array_like=True, frozen=True):
    """The worker of a seat is gone, `guilty` if it was deciding for that seat; the next one opens the agent again."""

    key: int
    guilty: bool


class Free(msgspec.Struct, tag=True, array_like=True, frozen=True):
    """What one more agent may need of each worker, and agents cost, in shares of a core, as often as it changes."""

    left: tuple[float, ...]
    most: float  # what the seats of one worker may need together; one without seats takes any agent
    costs: dict[str, float]  # by `capacity.cost_name`
    key: int = 0


FromService = FromWorker | Lost | Free

_from_service: msgspec.msgpack.Decoder[FromService] = msgspec.msgpack.Decoder(FromService)


def read_from_service(body: bytes) -> FromService:
    """Decode a frame body at the end of a process with rooms."""
    return _from_service.decode(body)
