"""How long steps take, roughly, in seconds of one core: measured on 2026-11-23, -25 and -26 or called an estimate.

Where the paper's networks are trained for the paper's epochs, its own times stand here (sections "Computing Resources"
and "Inference Speed of DP/BASS"): on an NVIDIA RTX A6000. On a CPU they take many times as long.
"""

import math
from typing import Any

from movingout.agents.reinforcement.mappo_config import PAPER, ComediConfig
from movingout.maps import map_names
from movingout.matches.match import Match
from movingout.matches.paper.budgets import Budget
from movingout.matches.paper.methods import Method, trained_id
from movingout.world.constants import LIMIT_TICKS

_EPISODE = 1.5  # of two scripted people, 500 ticks; 0.7 to 1.7, on idle and busy machines
_START = 4.0  # of a training: reading episodes, exporting
_UPDATE = {"mlp": 0.01, "gru": 0.02, "dp": 0.045, "bass": 0.015}  # of a network of width 128, 128 windows
_PAPER_UPDATE = {"mlp": 0.12, "gru": 0.48, "dp": 0.6, "bass": 0.03}  # 256 windows in bf16, on a core; BASS an estimate
_PICTURES = 5.0  # drawing the episodes of map 6
_PICTURE_UPDATE = {"dp": 0.05, "bass": 0.44}  # 32 pictures; with BASS, of the simulator and of its progress
_PAPER_TRAINING = {"mlp": 2700.0, "gru": 2700.0, "dp": 7200.0, "bass": 2700.0}  # A6000; not said for BASS's simulator
_FRAMES, _PAPER_FRAMES = 750.0, 1000.0  # per second of reinforcement learning; the paper: 30 M in 5 to 15 hours
_MATCH = {"mlp": 0.4, "gru": 0.4, "mappo": 0.4, "comedi": 0.4, "dp": 0.5, "bass": 1.0}  # both seats, 500 ticks
_ORACLE = 60.0  # an estimate
_PAPER_DP_CPU = {"dp": 14.0, "bass": 110.0}  # twelve matches at once; BASS an estimate, from one with eight steps
_PAPER_DP = 17.0  # 69 ms per decision, every four ticks in both seats


def recording_seconds(challenge: int, budget: Budget) -> float:
    """Of one core, for scripted people."""
    episodes = budget.variants if challenge == 2 else budget.people * budget.episodes  # two populations, in pairs
    return len(map_names()) * episodes * (0.5 + _EPISODE * budget.ticks / LIMIT_TICKS)


def training_seconds(method: Method, budget: Budget) -> float:
    """Of one training; nothing is trained where the simulator is shared."""
    if method.simulator and not method.learns:
        return _START
    words = budget.options.get(method.kind, ())
    if method.plays:
        return _reinforcement_seconds(method, words)
    if "--updates" not in words:
        return _PAPER_TRAINING[method.kind]
    updates = float(words[words.index("--updates") + 1]) / (4 if method.maps else 1)
    if method.pictures:
        return _START + _PICTURES + _PICTURE_UPDATE[method.kind] * updates
    if budget.preset == "paper":
        return _START + _PAPER_UPDATE[method.kind] * updates
    return _START + _UPDATE[method.kind] * _larger(words) * updates


def _larger(words: tuple[Any, ...]) -> float:
    """What an update of a small network costs, relative to width 128 and 128 windows.

    By the square root of the width: of 256 and 256 windows it was 2.6 times for DP, 3.0 for BASS.
    """
    said = dict(zip(words[::2], words[1::2], strict=True))
    return float(said["--batch"]) / 128 * math.sqrt(float(said["--width"]) / 128)


def _reinforcement_seconds(method: Method, words: tuple[Any, ...]) -> float:
    """Of one training; CoMeDi trains its conventions and the answer to them."""
    said = dict(zip(words[::2], words[1::2], strict=True))
    agents = int(said.get("--members", ComediConfig().members)) + 1 if method.kind == "comedi" else 1
    if "--frames" not in said:
        return agents * float(PAPER["frames"]) / _PAPER_FRAMES
    return _START + agents * float(said["--frames"]) / _FRAMES


def match_seconds(match: Match, budget: Budget) -> float:
    """Of one core."""
    kinds = [trained_id(agent_id).method.partition("-")[0] for agent_id in match.seats]
    seconds = max(_MATCH[kind] for kind in kinds)
    if any("simulator=oracle" in agent_id for agent_id in match.seats):
        seconds = _ORACLE
    if budget.preset == "paper":
        on_a_cpu = max(_PAPER_DP_CPU.get(kind, 0.0) for kind in kinds)
        seconds += _PAPER_DP if budget.gpu and on_a_cpu else on_a_cpu
    return seconds * match.ticks / LIMIT_TICKS


def span(seconds: float) -> str:
    """`40 s`, `12 min`, `3.5 h`, `20 days`."""
    for limit, unit, name, digits in ((90, 1, "s", 0), (5400, 60, "min", 0), (2 * 86400, 3600, "h", 1)):
        if seconds < limit:
            return f"{seconds / unit:.{digits}f} {name}"
    return f"{seconds / 86400:.0f} days"
