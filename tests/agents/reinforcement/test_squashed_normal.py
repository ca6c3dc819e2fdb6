"""Densities before squashing: ratios are those of the actions, also at the bounds of their range."""

from typing import Any

import pytest
import torch

pytest.importorskip("torchrl")

from torchrl.modules import TanhNormal

from movingout.agents.reinforcement.squashed_normal import SquashedNormal
from movingout.agents.reinforcement.tanh_actor import HIGH, LOW

RANGE = {"low": torch.tensor(LOW), "high": torch.tensor(HIGH)}
Ours: Any = SquashedNormal  # torch tells no types of densities
OLD = torch.tensor([0.3, -0.2, 0.1, 0.4]), torch.tensor([0.5, 0.8, 0.3, 0.6])
NEW = torch.tensor([0.2, -0.1, 0.3, 0.2]), torch.tensor([0.6, 0.7, 0.4, 0.5])


def squashed(drawn: torch.Tensor) -> torch.Tensor:
    return RANGE["low"] + (RANGE["high"] - RANGE["low"]) * (torch.tanh(drawn) + 1.0) / 2.0


def test_ratios_are_those_of_the_squashed_actions() -> None:
    drawn = OLD[0] + OLD[1] * torch.randn(50, 4, generator=torch.Generator().manual_seed(0))
    ours = Ours(*NEW).log_prob(drawn) - Ours(*OLD).log_prob(drawn)
    theirs = [TanhNormal(*one, **RANGE).log_prob(squashed(drawn)) for one in (NEW, OLD)]
    torch.testing.assert_close(ours, theirs[0] - theirs[1], atol=1e-3, rtol=1e-3)


def test_entropy_is_that_of_the_squashed_actions() -> None:
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(0)
        many = [one.expand(20_000, 4) for one in OLD]
        ours = Ours(*many).entropy().mean()
        there = TanhNormal(*OLD, **RANGE)
        theirs = -there.log_prob(there.rsample((20_000,))).mean()
    torch.testing.assert_close(ours, theirs, atol=0.03, rtol=0.0)


@pytest.mark.parametrize("loc", [20.0, -200.0])
def test_an_actor_that_is_certain_of_a_bound_can_still_learn(loc: float) -> None:
    old, scale = torch.full((1, 4), loc), torch.full((1, 4), 1e-3)
    new = (old * 1.001).requires_grad_()
    drawn = old + scale * 2.0
    now = Ours(new, scale)
    ratio = torch.exp(now.log_prob(drawn) - Ours(old, scale).log_prob(drawn))
    loss: Any = ratio.sum() + now.entropy().sum()
    loss.backward()
    assert ratio.isfinite().all() and new.grad is not None and new.grad.isfinite().all()
