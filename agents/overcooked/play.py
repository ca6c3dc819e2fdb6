"""Pairs of cooks at play: both the Diffusion Policy, alone or with simulation and selection on top."""

import numpy as np
import torch
from torch import Tensor

from movingout.agents.bass.selection import choice_from_scores, joint_chunks
from movingout.agents.checkpoint.policy_spec import ACTION_WIDTH as ROW_WIDTH
from movingout.agents.overcooked.kitchen import Kitchen, Singles
from movingout.agents.overcooked.training import SELECTION, KitchenParts, acting_rows

EXECUTE = 2  # ticks between decisions


def play_kitchen(parts: KitchenParts, games: int, ticks: int, seed: int, *, bass: bool) -> list[float]:
    """The points of each of some games in which both cooks are of one kind; game g draws its noise from (seed, g)."""
    kitchens = [Kitchen() for _ in range(games)]
    noise = [np.random.default_rng([seed, number]) for number in range(games)]
    points = np.zeros(games)
    for tick in range(0, ticks, EXECUTE):
        seen = np.array([[kitchen.observation(cook) for cook in (0, 1)] for kitchen in kitchens])
        chunks = (_selected if bass else _sampled)(parts, seen, noise)
        for ahead in range(min(EXECUTE, ticks - tick)):
            points += [kitchen.step(chunk[:, ahead]) for kitchen, chunk in zip(kitchens, chunks, strict=True)]
    return points.tolist()


def _chunks(parts: KitchenParts, seen: Singles, noise: list[np.random.Generator]) -> Singles:
    """Chunks (G, K, H, 5) of views (G, K, 120)."""
    games, views, size = seen.shape
    spec = parts.policy.spec
    shape = views, max(parts.policy.noise_rows, 1), spec.horizon, ROW_WIDTH
    drawn = np.concatenate([one.standard_normal(shape, dtype=np.float32) for one in noise])
    with torch.inference_mode():
        found = parts.policy(torch.from_numpy(seen.reshape(-1, 1, size)), torch.from_numpy(drawn))
    chunks: Singles = found.numpy().reshape(games, views, spec.horizon, ROW_WIDTH)
    return chunks


def _sampled(parts: KitchenParts, seen: Singles, noise: list[np.random.Generator]) -> Singles:
    """One chunk for each cook (G, 2, H, 5)."""
    return _chunks(parts, seen, noise)


def _selected(parts: KitchenParts, seen: Singles, noise: list[np.random.Generator]) -> Singles:
    """For each cook the best of its candidates (G, 2, H, 5)."""
    counts = [SELECTION.own, SELECTION.partner]
    chosen = []
    for cook in (0, 1):
        views = np.repeat(seen[:, [cook, 1 - cook]], counts, axis=1)
        candidates = _chunks(parts, views, noise)
        scores = _scores(parts, seen[:, cook], candidates)
        best = [choice_from_scores(each, np.empty(0), SELECTION).index for each in scores]
        chosen.append(candidates[np.arange(len(seen)), best])
    return np.stack(chosen, axis=1)


def _scores(parts: KitchenParts, seen: Singles, candidates: Singles) -> Singles:
    """The progress (G, R) after each pair of candidates (G, own + partner, H, 5)."""
    acting = acting_rows(candidates).astype(np.float64)
    own, partner = acting[:, : SELECTION.own], acting[:, SELECTION.own :]
    joints = np.array([joint_chunks(0, mine, theirs, SELECTION) for mine, theirs in zip(own, partner, strict=True)])
    games, rollouts = joints.shape[:2]
    actions = torch.from_numpy(joints.reshape(games * rollouts, SELECTION.depth, -1).astype(np.float32))
    start = torch.from_numpy(np.repeat(seen, rollouts, axis=0))
    with torch.inference_mode():
        after: Tensor = parts.value(parts.dynamics(start, actions))
    found: Singles = after.numpy().reshape(games, rollouts)
    return found
