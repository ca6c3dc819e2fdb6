"""The scene and the transforms for Foxglove and Lichtblick, derived from the states when a file is finished.

Every message is complete in itself, because viewers restore only the newest one of each topic when seeking. Bodies
hang on frames, so that only `/tf` moves. Protobuf, since that is what the viewers draw without set-up.
"""

import math
from collections.abc import Sequence
from typing import Any

from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.LinePrimitive_pb2 import LinePrimitive
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from mcap_protobuf.schema import build_file_descriptor_set

from movingout.maps.spec import ARENA_HALF, SEAT_COLOURS, MapSpec
from movingout.recordings import meshes
from movingout.recordings.episode import Event
from movingout.recordings.meshes import Colour, Mesh
from movingout.world.state import WorldState

WORLD_FRAME = "world"
TOPICS: dict[str, Any] = {
    "/scene/static": SceneUpdate,
    "/scene/bodies": SceneUpdate,
    "/tf": FrameTransforms,
    "/log": Log,
}

_GOOD_NEWS = frozenset({"start", "grab", "release", "delivered", "resume", "return", "ping", "end"})


def descriptor(message: Any) -> bytes:
    """The schema of a protobuf topic, as MCAP wants it."""
    return bytes(build_file_descriptor_set(message).SerializeToString())


def static_scene(spec: MapSpec, at_ns: int) -> bytes:
    """Floor edge, goals and walls."""
    scene = SceneUpdate()
    _edge(_entity(scene, "arena", WORLD_FRAME, at_ns))
    for name, mesh, colour in meshes.map_meshes(spec):
        _add(_entity(scene, name, WORLD_FRAME, at_ns), mesh, colour, 0.5 if name.startswith("goal") else 1.0)
    return bytes(scene.SerializeToString())


def body_scene(spec: MapSpec, delivered: Sequence[bool], at_ns: int) -> bytes:
    """Both robots and every item; sent again when an item is delivered or taken out."""
    scene = SceneUpdate()
    for colour, rgb in zip(SEAT_COLOURS, meshes.SEAT_RGB, strict=True):
        entity = _entity(scene, colour, colour, at_ns)
        _add(entity, meshes.robot_mesh(), rgb)
        _add(entity, meshes.nose_mesh(), rgb)
    for item, done in zip(spec.items, delivered, strict=True):
        name = f"item/{item.id}"
        rgb = meshes.DELIVERED_RGB if done else meshes.ITEM_RGB
        _add(_entity(scene, name, name, at_ns), meshes.item_mesh(item), rgb)
    return bytes(scene.SerializeToString())


def log_line(event: Event, at_ns: int) -> bytes:
    """An event as a line for people."""
    who = SEAT_COLOURS[event.seat] if event.seat >= 0 else "room"
    what = event.kind.replace("_", " ") + (f" item {event.item}" if event.item >= 0 else "")
    line = Log(name="room", message=f"tick {event.tick}: {who} {what}" + (f" ({event.detail})" if event.detail else ""))
    line.level = Log.INFO if event.kind in _GOOD_NEWS else Log.WARNING
    _stamp(line.timestamp, at_ns)
    return bytes(line.SerializeToString())


class Transforms:
    """The frames of all bodies; one message object is reused, since only its numbers change."""

    def __init__(self, spec: MapSpec) -> None:
        self._message = FrameTransforms()
        for name in (*SEAT_COLOURS, *(f"item/{item.id}" for item in spec.items)):
            self._message.transforms.add(parent_frame_id=WORLD_FRAME, child_frame_id=name)

    def of(self, state: WorldState, at_ns: int) -> bytes:
        poses = state.robot_poses.tolist() + state.item_poses.tolist()
        for transform, (x, y, angle) in zip(self._message.transforms, poses, strict=True):
            _stamp(transform.timestamp, at_ns)
            transform.translation.x, transform.translation.y = x, y
            transform.rotation.z, transform.rotation.w = math.sin(angle / 2), math.cos(angle / 2)
        return bytes(self._message.SerializeToString())


def _entity(scene: Any, name: str, frame: str, at_ns: int) -> Any:
    entity = scene.entities.add(id=name, frame_id=frame, frame_locked=True)
    _stamp(entity.timestamp, at_ns)
    return entity


def _add(entity: Any, mesh: Mesh, colour: Colour, alpha: float = 1.0) -> None:
    triangles = entity.triangles.add()
    triangles.pose.orientation.w = 1.0
    triangles.color.r, triangles.color.g, triangles.color.b = colour
    triangles.color.a = alpha
    for x, y, z in mesh.vertices.tolist():
        triangles.points.add(x=x, y=y, z=z)
    triangles.indices.extend(mesh.triangles.ravel().tolist())


def _edge(entity: Any) -> None:
    line = entity.lines.add(type=LinePrimitive.LINE_LOOP, thickness=2.0, scale_invariant=True)
    line.pose.orientation.w = 1.0
    line.color.a = 1.0
    for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
        line.points.add(x=x * ARENA_HALF, y=y * ARENA_HALF)


def _stamp(timestamp: Any, at_ns: int) -> None:
    timestamp.seconds, timestamp.nanos = divmod(at_ns, 1_000_000_000)
