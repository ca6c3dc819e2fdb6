"""One HTML file that plays an episode, or two side by side, without a server and without the network."""

from collections.abc import Sequence

from movingout.recordings.episode import Episode
from movingout.recordings.progress import with_progress
from movingout.recordings.viewer.cameras import CORNER, camera
from movingout.recordings.viewer.episode_scene import Layers
from movingout.recordings.viewer.side_by_side import SideBySide, row_width
from movingout.recordings.viewer.viewer import close_server, open_server
from movingout.world.constants import TICK_SECONDS

LAYERS = Layers(trail_ticks=50, heat="both", candidates=True)


def page(episodes: Sequence[Episode]) -> str:
    """The HTML, about 1.3 MB; its own play bar moves through the episode."""
    server = open_server("127.0.0.1", 0)
    try:
        view = camera(CORNER, row_width(len(episodes)), episodes[0].initial.robot_poses)
        server.initial_camera.position = view.position
        server.initial_camera.look_at = view.look_at
        row = SideBySide(server.scene, episodes)
        row.show(0, LAYERS)
        recording = server.get_scene_serializer()
        for tick in with_progress(range(1, row.last + 1), row.last, "drawing"):
            row.show(tick, LAYERS)
            recording.insert_sleep(TICK_SECONDS)
        return recording.as_html()
    finally:
        close_server(server)
