"""RRD: an episode for the Rerun viewer, with an arrangement of views: arena in 3D, metrics, actions, log.

Two timelines, `tick` and `play` (seconds of play). Entities: `arena` (floor, walls, goals, robots, items, trails),
`metrics/KEY`, `actions/COLOUR/NUMBER`, `log`.
"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from movingout.maps.spec import ARENA_HALF, SEAT_COLOURS, MapSpec, Rect
from movingout.recordings import meshes
from movingout.recordings.episode import Episode
from movingout.recordings.errors import RecordingError
from movingout.recordings.exports.plan import ExportPlan
from movingout.recordings.exports.target import new_target
from movingout.recordings.file_format.derived_topics import curves
from movingout.recordings.meshes import Colour, Mesh
from movingout.world.constants import TICK_SECONDS
from movingout.world.metrics import METRICS
from movingout.world.state import Floats, WorldState

APPLICATION = "moving_out"
ACTIONS = ("distance", "heading", "grasp")
TRAIL_TICKS = 50
_FLOOR: Colour = (0.96, 0.96, 0.96)
_FLOOR_THICKNESS, _TRAIL_HEIGHT, _TRAIL_RADIUS = 0.02, 0.012, 0.008  # arena units


def write(plan: ExportPlan) -> None:
    """One recording into the file that was named; several into a folder. Raises RecordingError."""
    single = plan.target.suffix == ".rrd"
    if plan.target.suffix and (not single or len(plan.recordings) > 1):
        raise RecordingError(f"{plan.target.name}: one recording becomes NAME.rrd, several a folder without ending")
    with new_target(plan.target) as part:
        if not single:
            part.mkdir()
        for episode, _ in plan.episodes("writing"):
            draw(episode, part if single else part / f"{episode.header.episode_id}.rrd")


def draw(episode: Episode, file: Path) -> None:
    """Write one episode. Raises OSError where the file cannot be written.

    Rerun keeps it in memory, some 3 kB per tick: on a full disk its own writer may wait for ever, or lose the end of a
    file and say nothing.
    """
    with rr.RecordingStream(APPLICATION, recording_id=episode.header.episode_id) as stream:
        kept = stream.memory_recording()
        stream.send_blueprint(blueprint(), make_active=False, make_default=True)
        _log_episode(stream, episode)
    file.write_bytes(kept.drain_as_bytes())


def _log_episode(stream: rr.RecordingStream, episode: Episode) -> None:
    _log_map(stream, episode.header.map)
    _log_bodies(stream, episode)
    values = curves(episode)
    for number, state in enumerate(episode.states):
        stream.set_time("tick", sequence=number)
        stream.set_time("play", duration=number * TICK_SECONDS)
        _log_state(stream, state)
        for seat, colour in enumerate(SEAT_COLOURS):
            strip = trail(episode.states, seat, number)
            lines = rr.LineStrips3D([strip], colors=[meshes.pixel(meshes.SEAT_RGB[seat])], radii=[_TRAIL_RADIUS])
            stream.log(f"arena/trails/{colour}", lines)
        if number:
            _log_tick(stream, episode, number, {key: row[number - 1] for key, row in values.items()})
    _log_events(stream, episode)


def blueprint() -> rrb.Blueprint:
    """The arrangement that the viewer opens with: metrics of one range share a chart."""
    shares = [f"$origin/{metric.key}" for metric in METRICS if not metric.unit]
    others = [f"$origin/{metric.key}" for metric in METRICS if metric.unit]
    return rrb.Blueprint(
        rrb.Horizontal(
            rrb.Spatial3DView(origin="/arena", name="Arena"),
            rrb.Vertical(
                rrb.TimeSeriesView(origin="/metrics", contents=shares, name="Metrics"),
                rrb.TimeSeriesView(origin="/metrics", contents=others, name="Times [s]"),
                *(
                    rrb.TimeSeriesView(origin=f"/actions/{colour}", name=f"Actions, {colour}")
                    for colour in SEAT_COLOURS
                ),
                rrb.TextLogView(origin="/log", name="Events"),
            ),
            column_shares=[3, 2],
        ),
        collapse_panels=True,
    )


def trail(states: tuple[WorldState, ...], seat: int, tick: int) -> Floats:
    """(P, 3) where a robot was in the last ticks, just above the floor."""
    places = np.array([state.robot_poses[seat, :2] for state in states[max(0, tick - TRAIL_TICKS) : tick + 1]])
    return np.column_stack([places, np.full(len(places), _TRAIL_HEIGHT)])


def _log_map(stream: rr.RecordingStream, spec: MapSpec) -> None:
    arena = Rect(-ARENA_HALF, -ARENA_HALF, ARENA_HALF, ARENA_HALF)
    stream.log("arena", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    stream.log("arena/floor", _boxes([arena], -_FLOOR_THICKNESS, 0.0, _FLOOR), static=True)
    stream.log("arena/goals", _boxes(spec.goals, 0.0, meshes.GOAL_HEIGHT, meshes.GOAL_RGB), static=True)
    if spec.walls:
        stream.log("arena/walls", _boxes(spec.walls, 0.0, meshes.WALL_HEIGHT, meshes.WALL_RGB), static=True)


def _boxes(rects: tuple[Rect, ...] | list[Rect], bottom: float, top: float, colour: Colour) -> rr.Boxes3D:
    centres = [((rect.left + rect.right) / 2, (rect.bottom + rect.top) / 2, (bottom + top) / 2) for rect in rects]
    halves = [((rect.right - rect.left) / 2, (rect.top - rect.bottom) / 2, (top - bottom) / 2) for rect in rects]
    return rr.Boxes3D(centers=centres, half_sizes=halves, colors=[meshes.pixel(colour)], fill_mode="solid")


def _log_bodies(stream: rr.RecordingStream, episode: Episode) -> None:
    """The shape of each body, and the players' names; transforms move them."""
    for seat, colour in enumerate(SEAT_COLOURS):
        stream.log(f"arena/{colour}/body", _mesh(meshes.robot_mesh(), meshes.SEAT_RGB[seat]), static=True)
        stream.log(f"arena/{colour}/nose", _mesh(meshes.nose_mesh(), (1.0, 1.0, 1.0)), static=True)
        above = [(0.0, 0.0, 2 * meshes.ROBOT_HEIGHT)]
        name = rr.Points3D(above, radii=[0.001], labels=[episode.header.seats[seat].name])
        stream.log(f"arena/{colour}/name", name, static=True)
    for place, item in enumerate(episode.header.map.items):  # by place, as events name them: ids may have gaps
        stream.log(f"arena/items/{place}", _mesh(meshes.item_mesh(item), meshes.ITEM_RGB), static=True)


def _mesh(mesh: Mesh, colour: Colour) -> rr.Mesh3D:
    """Flat shaded: each triangle has vertices of its own."""
    corners = mesh.vertices[mesh.triangles]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = across / np.linalg.norm(across, axis=1, keepdims=True)
    return rr.Mesh3D(
        vertex_positions=corners.reshape(-1, 3),
        vertex_normals=np.repeat(normals, 3, axis=0),
        albedo_factor=meshes.pixel(colour),
    )


def _log_state(stream: rr.RecordingStream, state: WorldState) -> None:
    bodies = [*SEAT_COLOURS, *(f"items/{place}" for place in range(len(state.item_poses)))]
    for name, (x, y, angle) in zip(bodies, [*state.robot_poses.tolist(), *state.item_poses.tolist()], strict=True):
        turned = rr.RotationAxisAngle(axis=(0, 0, 1), radians=angle)
        stream.log(f"arena/{name}", rr.Transform3D(translation=(x, y, 0.0), rotation=turned))


def _log_tick(stream: rr.RecordingStream, episode: Episode, number: int, values: dict[str, float | None]) -> None:
    for metric in METRICS:
        value = values[metric.key]
        if value is not None:
            stream.log(f"metrics/{metric.key}", rr.Scalars(value))
    for colour, action in zip(SEAT_COLOURS, episode.ticks[number - 1].actions.tolist(), strict=True):
        for name, quantity in zip(ACTIONS, action, strict=True):
            stream.log(f"actions/{colour}/{name}", rr.Scalars(quantity))


def _log_events(stream: rr.RecordingStream, episode: Episode) -> None:
    for event in episode.events:
        stream.set_time("tick", sequence=event.tick)
        stream.set_time("play", duration=event.tick * TICK_SECONDS)
        stream.log("log", rr.TextLog(" ".join(_words(event.kind, event.seat, event.item, event.detail)), level="INFO"))


def _words(kind: str, seat: int, item: int, detail: str) -> Iterator[str]:
    if seat >= 0:
        yield SEAT_COLOURS[seat]
    yield kind.replace("_", " ")
    if item >= 0:
        yield f"item {item}"
    if detail:
        yield f"({detail})"
