"""A recording for replay in the browser: poses every 20 ms by re-simulation, events, metrics and agents' decisions.

Where a re-simulation does not reproduce the recorded states (another engine, imported data), the poses between
ticks are interpolated from the recorded states instead, and the summary says so.
"""

import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from movingout.maps.json_format import map_to_json
from movingout.maps.spec import SEAT_COLOURS
from movingout.recordings.episode import Episode
from movingout.recordings.file_format.derived_topics import curves, result
from movingout.recordings.file_format.metadata import utc
from movingout.recordings.file_format.reader import read_episode
from movingout.recordings.verification import difference
from movingout.recordings.viewer.candidates import candidates, guesses, made_in
from movingout.world import World
from movingout.world.constants import POSES_PER_TICK, TICK_MS
from movingout.world.metrics import NO_VALUE, to_numbers
from movingout.world.state import Floats, WorldState


class BrowserReplay(NamedTuple):
    """What a browser needs to show an episode again."""

    summary: dict[str, Any]  # JSON
    frames: npt.NDArray[np.int16]  # (1 + 5 T, 2 + N, 3) of scaled x, y, angle; angles wrap
    decision_traces: list[dict[str, Any]]  # JSON: what agents weighed, in order of ticks


def browser_replay(path: Path, position_scale: float, angle_scale: float) -> BrowserReplay:
    """A recording prepared for the browser.

    Takes about a second for a long episode, so call it in a worker process. RecordingError when it cannot be read.
    """
    episode = read_episode(path)
    poses, exact = replay_poses(episode)
    scaled = np.rint(poses * np.array([position_scale, position_scale, angle_scale]))
    scaled[..., :2] = np.clip(scaled[..., :2], -32768, 32767)
    frames = scaled.astype(np.int64).astype(np.int16)  # the cast wraps angles modulo one turn
    weighed = decision_trace(episode)
    return BrowserReplay({**summary(episode), "exact": exact, "has_thoughts": bool(weighed)}, frames, weighed)


def replay_poses(episode: Episode) -> tuple[Floats, bool]:
    """Poses (1 + 5 T, 2 + N, 3) at 20 ms, and whether all of them are re-simulated."""
    world = World(episode.header.map)
    blocks = [_poses(episode.initial)[None]]
    exact = difference(episode.initial, world.state()) is None
    for before, tick in zip(episode.states, episode.ticks, strict=False):
        if exact:
            world.step(tick.actions)
            exact = difference(tick.state, world.state()) is None
        blocks.append(world.sub_poses() if exact else _between(before, tick.state))
    return np.concatenate(blocks), exact


def _poses(state: WorldState) -> Floats:
    return np.concatenate([state.robot_poses, state.item_poses])


def _between(before: WorldState, after: WorldState) -> Floats:
    """Five poses by linear interpolation; angles take the shorter way."""
    start, end = _poses(before), _poses(after)
    way = end - start
    way[:, 2] = (way[:, 2] + math.pi) % (2 * math.pi) - math.pi
    parts = np.arange(1, POSES_PER_TICK + 1) / POSES_PER_TICK
    between: Floats = start + parts[:, None, None] * way
    return between


def summary(episode: Episode) -> dict[str, Any]:
    """Everything about an episode but its poses, as JSON."""
    header = episode.header
    return {
        "id": header.episode_id,
        "map": map_to_json(header.map),
        "started": utc(header.started_ns),
        "seed": header.seed,
        "source": header.source,
        "study": dict(header.study),
        "limit_ticks": header.limit_ticks,
        "ticks": len(episode.ticks),
        "outcome": episode.outcome,
        "complete": episode.complete,
        "damage": episode.damage,
        "versions": dict(episode.versions),
        "seats": [
            {"colour": colour, "kind": seat.kind, "name": seat.name, "device": seat.device}
            for colour, seat in zip(SEAT_COLOURS, header.seats, strict=True)
        ],
        "pose_ms": TICK_MS // POSES_PER_TICK,
        "poses_per_tick": POSES_PER_TICK,
        "held": [state.held.tolist() for state in episode.states],
        "delivered_at_start": list(episode.delivered_after(0)),
        "delivered": [list(tick.delivered) for tick in episode.ticks],
        "events": [
            {"tick": e.tick, "kind": e.kind, "seat": e.seat, "item": e.item, "detail": e.detail} for e in episode.events
        ],
        "metrics": to_numbers(result(episode)),
        "curves": {key: [NO_VALUE if one is None else one for one in curve] for key, curve in curves(episode).items()},
    }


def decision_trace(episode: Episode) -> list[dict[str, Any]]:
    """The decisions in which an agent named candidates: scores, ways, and what was expected of the chosen one."""
    states = episode.states
    found = []
    for decision in episode.decisions:
        state = made_in(decision, states)
        considered = candidates(decision, state)
        if considered:
            chosen = next((index for index, one in enumerate(considered) if one.chosen), -1)
            found.append(
                {
                    "seat": decision.seat,
                    "tick": decision.tick,
                    "chosen": chosen,
                    "scores": [round(one.score, 4) for one in considered],
                    "ways": [np.round(one.path, 4).tolist() for one in considered],
                    "moves": np.round(considered[chosen].moves, 4).tolist() if chosen >= 0 else [],
                    "robots": np.round(considered[chosen].robots, 4).tolist() if chosen >= 0 else [],
                    "guesses": np.round(guesses(decision, state), 4).tolist(),
                }
            )
    return found
