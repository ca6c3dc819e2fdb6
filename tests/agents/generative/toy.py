"""Two partners that are easy to tell apart, and the smallest models of them."""

from pathlib import Path

import numpy as np

from movingout.agents.checkpoint.card import Training
from movingout.agents.checkpoint.checkpoint import Checkpoint
from movingout.agents.data.dataset import SeatSamples, Windows, windows_of
from movingout.agents.generative.config import LatentConfig
from movingout.agents.generative.policy import LatentPolicy
from movingout.agents.observation.features import FeatureSet
from movingout.agents.policies.export import save_policy

MODEL = "latent@toy"
TINY = LatentConfig(
    layout="relative-v1", denoiser="items", width=16, depth=1, latent=3, batch=64, episode_windows=8, updates=250,
    rate=5e-3, warmup=10, evaluate_every=250, ema=0.9, held_out=0.0, mirror=0.0, beta=0.001, precision="fp32",
)  # fmt: skip


def windows(episodes: int = 12, ticks: int = 24) -> Windows:
    """Episodes by turns of one who drives ahead and one who drives back; what they see says nothing about who it is."""
    random = np.random.default_rng(0)
    pieces = []
    for number in range(episodes):
        seen = random.standard_normal((ticks, FeatureSet(TINY.layout).size)).astype(np.float32)
        speed = 0.9 if number % 2 else -0.9
        targets = np.tile(np.array([[speed, 1.0, 0.0, 1.0, -1.0]], np.float32), (ticks, 1))
        pieces.append(SeatSamples(f"p{number % 2}", seen, targets, np.zeros(ticks, np.float32)))
    return windows_of(pieces)


def untrained(folder: Path) -> Checkpoint:
    """A model with random weights, in `folder`/latent-toy."""
    training = Training(
        preset="fast", data_sha256="0" * 64, population="nobody", episodes=0, windows=0, updates=0, seed=0,
        created="2026-11-25",
    )  # fmt: skip
    policy = LatentPolicy(TINY.spec("latent"))
    return save_policy(folder / "latent-toy", MODEL, policy, ["HandOff"], training, "Toy", "A toy.")
