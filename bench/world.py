"""The overhead of the world over its engine: `World.step` against 20 `space.step` over the same states.

Rates are ticks per second of CPU time on one core. Ratios compare consecutive runs, so that they hold on a busy
machine too; absolute figures do not.
"""

import statistics
import time
from collections.abc import Callable

import numpy as np

from bench import print_table
from movingout.maps import MapSpec, load_map, map_names
from movingout.world import World
from movingout.world.constants import LIMIT_TICKS, SUB_STEP_SECONDS, SUB_STEPS_PER_HALF
from movingout.world.metrics import EpisodeMetrics
from movingout.world.observation import encoder
from movingout.world.state import Floats

TICKS = LIMIT_TICKS
ROUNDS = 5
TARGETS = {"bare": 0.90, "with sub-poses": 0.65, "everything": 0.45}


class EngineTimedWorld(World):
    """The same world, stepped by pymunk's `space.step`, with the CPU time spent in it summed."""

    engine_seconds = 0.0

    def _advance(self, blocks: tuple[int, ...], samples: object) -> None:
        step = self._bodies.space.step
        start = time.process_time()
        for _ in range(SUB_STEPS_PER_HALF):
            step(SUB_STEP_SECONDS)
        self.engine_seconds += time.process_time() - start - _CLOCK_SECONDS


def main() -> None:
    rows: list[list[str]] = []
    ratios: dict[str, list[float]] = {name: [] for name in VARIANTS}
    for map_name in map_names():
        spec, actions = load_map(map_name), driving(seed=7)
        rounds = [measure(spec, actions) for _ in range(ROUNDS)]
        limit = statistics.median(limit for limit, _ in rounds)
        row = [map_name, f"{TICKS / limit:,.0f}"]
        for name in VARIANTS:
            ratio = statistics.median(engine / seconds[name] for engine, seconds in rounds)
            ratios[name].append(ratio)
            row.append(f"{ratio:.2f}")
        rows.append(row)
    rows.append(["all maps, median", "", *(f"{statistics.median(ratios[name]):.2f}" for name in VARIANTS)])
    rows.append(["all maps, least", "", *(f"{min(ratios[name]):.2f}" for name in VARIANTS)])
    rows.append(["to reach", "", *(f"{TARGETS[name]:.2f}" for name in VARIANTS)])
    print_table("World.step as a share of 20 space.step over the same states", ["map", "limit", *VARIANTS], rows)


def measure(spec: MapSpec, actions: list[Floats]) -> tuple[float, dict[str, float]]:
    """CPU seconds of the engine alone, and of each variant, for the same episode."""
    world = EngineTimedWorld(spec, record_sub_poses=False)
    for action in actions:
        world.step(action)
    return world.engine_seconds, {name: run(spec, actions) for name, run in VARIANTS.items()}


def bare(spec: MapSpec, actions: list[Floats]) -> float:
    world = World(spec, record_sub_poses=False)
    start = time.process_time()
    for action in actions:
        world.step(action)
    return time.process_time() - start


def with_sub_poses(spec: MapSpec, actions: list[Floats]) -> float:
    world = World(spec)
    start = time.process_time()
    for action in actions:
        world.step(action)
        world.sub_poses()
    return time.process_time() - start


def everything(spec: MapSpec, actions: list[Floats]) -> float:
    """Sub-poses, state, both observations, metrics and deliveries in each tick."""
    world, metrics, observations = World(spec), EpisodeMetrics(spec), encoder(spec)
    before = world.state()
    start = time.process_time()
    for action in actions:
        world.step(action)
        world.sub_poses()
        after = world.state()
        observations.encode_both(after)
        metrics.update(before, action, after)
        world.delivered()
        before = after
    return time.process_time() - start


def driving(seed: int) -> list[Floats]:
    """Smooth random driving with occasional grasps: joint actions (2, 3), one per tick."""
    generator = np.random.default_rng(seed)
    headings = np.cumsum(generator.normal(0.0, 0.3, (TICKS, 2)), axis=0)
    grasps = generator.random((TICKS, 2)) < 0.1
    return list(np.stack([generator.uniform(0.3, 1.0, (TICKS, 2)), headings, grasps], axis=2))


def _clock_seconds() -> float:
    """CPU seconds of reading the CPU clock, to subtract from the engine's."""
    samples = []
    for _ in range(2000):
        start = time.process_time()
        samples.append(time.process_time() - start)
    return statistics.median(samples)


_CLOCK_SECONDS = _clock_seconds()
VARIANTS: dict[str, Callable[[MapSpec, list[Floats]], float]] = {
    "bare": bare,
    "with sub-poses": with_sub_poses,
    "everything": everything,
}
