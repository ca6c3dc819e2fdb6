"""The cost of matches: ticks and matches per second of CPU time of one core.

`idle` pairs in lockstep are compared with a bare `World.step` over the same ticks, in alternation, so that the ratio
holds on a busy machine. A policy network of the shipped size (residual MLP 512 x 3, 4 flow steps) with random weights
shows what batches gain over one match at a time; the weights do not change the cost.
"""

import statistics
import time
from collections.abc import Sequence

from bench import print_table
from movingout.agents.base import Agent
from movingout.agents.catalogue import load_agent
from movingout.agents.checkpoint.policy_spec import PolicySpec
from movingout.agents.inference.network import PolicyNetwork
from movingout.agents.inference.policy_agent import PolicyAgent
from movingout.maps import load_map
from movingout.matches.execution.lockstep import BATCH_SIZE, Lockstep
from movingout.matches.match import Match
from movingout.world import World
from movingout.world.constants import LIMIT_TICKS

MAP = "DistancePriority"
ROUNDS = 20  # short, so that other load affects both sides equally
TICKS = 200
BASS_TICKS, BASS_BATCH_SIZE = 40, 8
SPEC = {
    "kind": "dp", "layout": "aware-v1", "obs_horizon": 2, "horizon": 8, "execute": 4, "width": 512, "depth": 3,
}  # fmt: skip


def main() -> None:
    idle = [Match(MAP, "idle", "idle", seed, ticks=TICKS) for seed in range(BATCH_SIZE)]
    lockstep, ratios, rates = Lockstep(), [], []
    for _ in range(ROUNDS):
        bare, seconds = bare_seconds(BATCH_SIZE * TICKS), lockstep_seconds(lockstep, idle)
        ratios.append(bare / seconds)
        rates.append(BATCH_SIZE * TICKS / seconds)
    scripted = [Match(MAP, "scripted", "scripted", seed, ticks=TICKS) for seed in range(2)]
    rows = [
        _row("idle", statistics.median(rates)),
        _row("scripted", 2 * TICKS / lockstep_seconds(Lockstep(), scripted)),
    ]
    network = random_network()
    rows += [_row(name, rate) for name, rate in {**policy_rates(network), **bass_rates()}.items()]
    print_table(
        f"Matches on {MAP}, pairs of one agent, per core",
        ["agent", "ticks/s", f"matches of {LIMIT_TICKS} ticks/s"],
        rows,
    )
    print(f"idle pairs: {statistics.median(ratios):.2f} of the bare World.step rate (goal: 0.70)")
    alone, together = network_seconds(network)
    print(f"network: {alone / together:.1f} times the samples per second in batches of {2 * BATCH_SIZE} (goal: 5)")


def _row(name: str, ticks_per_second: float) -> list[str]:
    return [name, f"{ticks_per_second:,.0f}", f"{ticks_per_second / LIMIT_TICKS:.2f}"]


def bare_seconds(ticks: int) -> float:
    """CPU seconds of the world alone, with neutral actions, in episodes of `TICKS`."""
    begun = time.process_time()
    for _ in range(ticks // TICKS):
        world = World(load_map(MAP), record_sub_poses=False)
        for _ in range(TICKS):
            world.step([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    return time.process_time() - begun


def lockstep_seconds(lockstep: Lockstep, matches: Sequence[Match]) -> float:
    begun = time.process_time()
    failed = [result.failure for result in lockstep.play(matches) if result.ending == "failed"]
    assert not failed, failed[0]
    return time.process_time() - begun


def random_network() -> PolicyNetwork:
    """An untrained policy of the shipped size."""
    from movingout.agents.kinds.policy import build_policy
    from movingout.agents.policies.export import export_policy

    spec = PolicySpec.model_validate(SPEC)
    return PolicyNetwork(spec, export_policy(build_policy(spec)))


def policy_rates(network: PolicyNetwork) -> dict[str, float]:
    """Ticks per second, one match at a time and in lockstep."""

    def load(agent_id: str) -> Agent:
        return PolicyAgent(network.spec, network) if agent_id == "dp" else load_agent(agent_id)

    matches = [Match(MAP, "dp", "dp", seed, ticks=TICKS // 4) for seed in range(BATCH_SIZE)]
    ticks = len(matches) * TICKS // 4
    alone = lockstep_seconds(Lockstep(batch_size=1, load=load), matches[:8]) * len(matches) / 8
    together = lockstep_seconds(Lockstep(load=load), matches)
    return {"dp, one match at a time": ticks / alone, f"dp, {BATCH_SIZE} matches together": ticks / together}


def bass_rates() -> dict[str, float]:
    """The same for pairs of the shipped BASS agent, which scores a batch of candidates per decision."""
    matches = [Match(MAP, "bass@all", "bass@all", seed, ticks=BASS_TICKS) for seed in range(BASS_BATCH_SIZE)]
    ticks = len(matches) * BASS_TICKS
    alone = lockstep_seconds(Lockstep(batch_size=1), matches)
    together = lockstep_seconds(Lockstep(batch_size=BASS_BATCH_SIZE), matches)
    return {
        "bass@all, one match at a time": ticks / alone,
        f"bass@all, {BASS_BATCH_SIZE} matches together": ticks / together,
    }


def network_seconds(network: PolicyNetwork) -> tuple[float, float]:
    """CPU seconds for the same number of samples one by one, and in batches of both seats of all matches."""
    import numpy as np

    spec, random, count = network.spec, np.random.default_rng(0), 2 * BATCH_SIZE
    history = random.standard_normal((count, spec.obs_horizon, spec.features), dtype=np.float32)
    begun = time.process_time()
    for row in history:
        network.sample(row[None], random)
    alone = time.process_time() - begun
    begun = time.process_time()
    for _ in range(4):
        network.sample(history, random)
    return alone, (time.process_time() - begun) / 4
