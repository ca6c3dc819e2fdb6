"""The controls of one visitor: which episodes, the timeline, layers and camera.

Everything belongs to one client, so that two people look at the same recordings independently. Callbacks come from
viser's threads and `advance` from the viewer's own: a lock keeps them apart.
"""

import threading
from collections.abc import Callable, Sequence
from dataclasses import replace

import viser

from movingout.maps.spec import SEAT_COLOURS
from movingout.recordings.episode import Episode, Event
from movingout.recordings.errors import RecordingError
from movingout.recordings.viewer.cameras import CORNER, PRESETS, Camera, camera
from movingout.recordings.viewer.episode_scene import HEAT_CHOICES, EpisodeScene, Layers, score_table
from movingout.recordings.viewer.playback import SPEEDS, Playback
from movingout.recordings.viewer.recording_cache import RecordingCache
from movingout.recordings.viewer.side_by_side import SideBySide, row_width
from movingout.world.constants import TICK_SECONDS

ALONE = "nothing"
_STEPS = {"-10": -10, "-1": -1, "+1": 1, "+10": 10}
_LONGEST_TRAIL_S = 60.0
_TOLD = frozenset(
    {"grab", "release", "delivered", "undelivered", "pause", "resume", "drop", "return", "agent_error", "unseen_map"}
)

Look = Callable[[Camera], None]


class Panel:
    """The controls of one client and the scene they move. `look` moves the client's camera."""

    def __init__(self, gui: viser.GuiApi, scene: viser.SceneApi, cache: RecordingCache, look: Look) -> None:
        self._gui, self._scene, self._cache, self._look = gui, scene, cache, look
        self._lock = threading.RLock()
        self._layers = Layers()
        episodes = [cache.episode(name) for name in cache.shown_first]
        self._side_by_side = SideBySide(scene, episodes)
        self.playback = Playback(self._side_by_side.last)
        self._build(cache)
        self._after_change()
        self._aim(CORNER)

    @property
    def scenes(self) -> list[EpisodeScene]:
        return self._side_by_side.scenes

    def advance(self, elapsed_s: float) -> None:
        """Let time pass."""
        with self._lock:
            self.playback.advance(elapsed_s)
            self._follow()

    # ---- building ------------------------------------------------------------------------------------------

    def _build(self, cache: RecordingCache) -> None:
        self.about = self._gui.add_markdown("")
        if len(cache.names) > 1:
            self._build_choice(cache)
        with self._gui.add_folder("Playback"):
            self._build_playback()
        with self._gui.add_folder("Show"):
            self._build_layers()
        self.views = self._gui.add_button_group("Camera", PRESETS)
        self.views.on_click(lambda _: self._aim(self.views.value))
        with self._gui.add_folder("Candidates") as self._candidate_folder:
            self.scores = self._gui.add_markdown("")

    def _build_choice(self, cache: RecordingCache) -> None:
        first, *others = cache.shown_first
        self.left = self._gui.add_dropdown("Episode", cache.names, initial_value=first)
        self.right = self._gui.add_dropdown("Beside it", (ALONE, *cache.names), initial_value=(*others, ALONE)[0])
        self.left.on_update(lambda _: self._choose())
        self.right.on_update(lambda _: self._choose())

    def _build_playback(self) -> None:
        self.tick = self._gui.add_slider("Tick", 0, max(self.playback.last, 1), 1, 0)
        self.tick.on_update(lambda _: self._seek(int(self.tick.value)))
        self._state = self._gui.add_markdown("")
        self.play = self._gui.add_button("Play")
        self.play.on_click(lambda _: self._toggle())
        self.steps = self._gui.add_button_group("Step", tuple(_STEPS))
        self.steps.on_click(lambda _: self._step(_STEPS[self.steps.value]))
        self.events = self._gui.add_button_group("Event", ("before", "after"))
        self.events.on_click(lambda _: self._jump(forward=self.events.value == "after"))
        self.speed = self._gui.add_dropdown("Speed", tuple(f"{speed:g}x" for speed in SPEEDS), initial_value="1x")
        self.speed.on_update(lambda _: self._set_speed())

    def _build_layers(self) -> None:
        seconds = self._layers.trail_ticks * TICK_SECONDS
        self.trail = self._gui.add_slider("Trail (s)", 0.0, _LONGEST_TRAIL_S, 0.5, seconds)
        self.heat = self._gui.add_dropdown("Heat map", tuple(HEAT_CHOICES), initial_value=self._layers.heat)
        self.candidates = self._gui.add_checkbox("Candidates", self._layers.candidates)
        for control in (self.trail, self.heat, self.candidates):
            control.on_update(lambda _: self._change_layers())

    # ---- what a visitor does -------------------------------------------------------------------------------

    def _choose(self) -> None:
        with self._lock:
            names = [name for name in (self.left.value, self.right.value) if name != ALONE]
            try:
                episodes = [self._cache.episode(name) for name in names]
            except RecordingError as error:
                self.about.content = f"**Cannot show that:** {error}"
                return
            self._side_by_side.remove()
            self._side_by_side = SideBySide(self._scene, episodes)
            speed = self.playback.speed
            self.playback = Playback(self._side_by_side.last)
            self.playback.speed = speed
            self.tick.max = max(self._side_by_side.last, 1)
            self._move_slider()
            self._after_change()

    def _toggle(self) -> None:
        with self._lock:
            self.playback.toggle()
            self._follow()

    def _seek(self, tick: int) -> None:
        with self._lock:
            if tick != self.playback.tick:  # the slider also moves because the play head did
                self.playback.seek(tick)
            self._draw()

    def _step(self, ticks: int) -> None:
        with self._lock:
            self.playback.step(ticks)
            self._follow()

    def _jump(self, *, forward: bool) -> None:
        with self._lock:
            here = self.playback.tick
            ticks = {event.tick for shown in self.scenes for event in told_events(shown.episode)}
            if forward:
                target = min((tick for tick in ticks if tick > here), default=self.playback.last)
            else:
                target = max((tick for tick in ticks if tick < here), default=0)
            self.playback.step(target - here)
            self._follow()

    def _set_speed(self) -> None:
        self.playback.speed = float(self.speed.value.removesuffix("x"))

    def _change_layers(self) -> None:
        with self._lock:
            ticks = round(self.trail.value / TICK_SECONDS)
            self._layers = replace(
                self._layers, trail_ticks=ticks, heat=self.heat.value, candidates=self.candidates.value
            )
            self._draw()

    def _aim(self, preset: str) -> None:
        shown = self.scenes[0]
        robots = shown.episode.states[min(self.playback.tick, shown.last)].robot_poses.copy()
        robots[:, 0] += shown.shift
        self._look(camera(preset, row_width(len(self.scenes)), robots))

    # ---- showing -------------------------------------------------------------------------------------------

    def _after_change(self) -> None:
        self.about.content = "\n\n".join(about(shown.episode) for shown in self.scenes)
        self._candidate_folder.visible = any(shown.episode.decisions for shown in self.scenes)
        self._draw()

    def _follow(self) -> None:
        """Bring the controls and the scene to the play head."""
        label = "Pause" if self.playback.playing else "Play"
        if self.play.label != label:
            self.play.label = label
        self._move_slider()

    def _move_slider(self) -> None:
        """Where it moves, its own callback draws."""
        self.tick.value = self.playback.tick  # type: ignore[misc]  # viser's setter, which mypy overlooks

    def _draw(self) -> None:
        tick = self.playback.tick
        self._side_by_side.show(tick, self._layers)
        self._state.content = "  \n".join(happening(shown.episode, tick) for shown in self.scenes)
        if self._candidate_folder.visible:
            considered = [one for shown in self.scenes for one in shown.considered(tick)]
            self.scores.content = score_table(considered) or "none named yet"


def about(episode: Episode) -> str:
    """An episode in two lines."""
    header = episode.header
    blue, red = (seat.name or seat.kind for seat in header.seats)
    return f"**{header.map.title}** · {episode.outcome}  \nblue **{blue}**, red **{red}**"


def happening(episode: Episode, tick: int) -> str:
    """The time, what is in the hands and delivered, and what has just happened."""
    tick = min(tick, len(episode.ticks))
    items = episode.header.map.items
    held = [
        f"{colour} holds the {items[index].size} {items[index].shape}"
        for colour, index in zip(SEAT_COLOURS, episode.states[tick].held.tolist(), strict=True)
        if index >= 0
    ]
    delivered = sum(episode.ticks[tick - 1].delivered) if tick else 0
    latest = [event.kind.replace("_", " ") for event in told_events(episode) if event.tick == tick]
    words = [f"{tick * TICK_SECONDS:.1f} s", f"{delivered} of {len(items)} delivered", *held, *latest]
    return " · ".join(words)


def told_events(episode: Episode) -> Sequence[Event]:
    """The events worth stopping at."""
    return [event for event in episode.events if event.kind in _TOLD]
