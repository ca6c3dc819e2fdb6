"""One HTML file that plays an episode, or two side by side, without a server and without the network."""

from collections.abc import Sequence
from pathlib import Path

from recordings.episode import Episode
from recordings.errors import cannot
from recordings.progress import track
from recordings.viewer.cameras import CORNER, camera
from recordings.viewer.row import Row, row_width
from recordings.viewer.stage import Layers
from recordings.viewer.viewer import close_server, open_server
from world.metrics import TICK_S

LAYERS = Layers(trail_ticks=50, heat="both", candidates=True)


def write_page(episodes: Sequence[Episode], path: Path) -> None:
    """Write the page of one or two episodes. Raises RecordingError when it cannot be written."""
    text = page(episodes)
    part = path.with_name(path.name + ".part")
    try:
        part.write_text(text, encoding="utf-8")
        part.replace(path)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise cannot("write", path, error) from error


def page(episodes: Sequence[Episode]) -> str:
    """The HTML, about 1.3 MB; its own play bar moves through the episode."""
    server = open_server("127.0.0.1", 0)
    try:
        view = camera(CORNER, row_width(len(episodes)), episodes[0].initial.robot_poses)
        server.initial_camera.position = view.position
        server.initial_camera.look_at = view.look_at
        row = Row(server.scene, episodes)
        row.show(0, LAYERS)
        recording = server.get_scene_serializer()
        for tick in track(range(1, row.last + 1), row.last, "drawing"):
            row.show(tick, LAYERS)
            recording.insert_sleep(TICK_S)
        return recording.as_html()
    finally:
        close_server(server)
