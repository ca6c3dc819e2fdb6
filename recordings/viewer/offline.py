"""One HTML file that plays an episode, or two side by side, without a server and without the network."""

from collections.abc import Sequence

from recordings.episode import Episode
from recordings.progress import track
from recordings.viewer.cameras import CORNER, camera
from recordings.viewer.row import Row, row_width
from recordings.viewer.stage import Layers
from recordings.viewer.viewer import close_server, open_server
from world.metrics import TICK_S

LAYERS = Layers(trail_ticks=50, heat="both", candidates=True)


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
