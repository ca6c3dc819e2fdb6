"""Training the learned simulator of BASS from episodes (paper, "BASS Details").

From the top: episodes become single ticks; the simulator is fitted to them in one or several stages (`stages`), each a
`fit` with its own loss; validation counts how well ticks of people who are not trained on are predicted.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import torch
from torch import Tensor, nn

from movingout.agents.bass.config import BassConfig, Order
from movingout.agents.bass.dynamics import Dynamics, VaeDynamics, build_dynamics
from movingout.agents.bass.grasp_model import hands_of
from movingout.agents.bass.state_vector import ACTION_WIDTH, ITEMS_START, constant, moving_arrays
from movingout.agents.data.dataset import Indices, Singles, Trajectory, split_rows
from movingout.agents.training.fit import FitResult, TrainingTask, fit
from movingout.agents.training.gradients import Losses
from movingout.maps import MapSpec
from movingout.world.state import Floats

VALIDATION_ROWS = 8192
Batch = tuple[Tensor, Tensor, Tensor, Tensor]
"""States (B, 58), constants (B, 146), actions (B, 8), next states (B, 58)."""


@dataclass(frozen=True, slots=True, eq=False)
class Transitions:
    """Single ticks of many episodes."""

    before: Singles  # (M, 58)
    actions: Singles  # (M, 8) distance, cos, sin, toggle of blue and red
    after: Singles  # (M, 58)
    maps: Indices  # (M,) row of `constants`
    constants: Singles  # (K, 146)
    episodes: Indices  # (M,) number of the episode
    people: tuple[frozenset[str], ...]  # (E,) who is in each episode

    def __len__(self) -> int:
        return len(self.before)

    def presses(self, rows: Indices) -> Indices:
        """Those of the rows in which somebody presses, whether anything comes of it or not."""
        found: Indices = rows[(self.actions[rows].reshape(-1, 2, ACTION_WIDTH)[..., -1] > 0.5).any(axis=1)]
        return found


def transitions_of(trajectories: list[Trajectory]) -> Transitions:
    """Every tick of the episodes."""
    maps: dict[MapSpec, int] = {}
    pieces = []
    for number, trajectory in enumerate(trajectories):
        rows = moving_arrays(*trajectory.state_arrays)
        index = maps.setdefault(trajectory.map, len(maps))
        pieces.append((rows[:-1], action_rows(trajectory), rows[1:], np.full((trajectory.ticks, 2), (index, number))))
    before, actions, after, numbers = (np.concatenate(part) for part in zip(*pieces, strict=True))
    return Transitions(
        before.astype(np.float32),
        actions.astype(np.float32),
        after.astype(np.float32),
        numbers[:, 0],
        np.array([constant(the_map) for the_map in maps], dtype=np.float32),
        numbers[:, 1],
        tuple(trajectory.people for trajectory in trajectories),
    )


def action_rows(trajectory: Trajectory) -> Floats:
    """(T, 8): world actions as distance, cos, sin, toggle of blue and red."""
    distance, heading, toggle = (trajectory.actions[..., k] for k in range(3))
    rows = np.stack((distance, np.cos(heading), np.sin(heading), toggle > 0.5), axis=-1)
    return rows.reshape(len(rows), -1)


def train_dynamics(config: BassConfig, data: Transitions, folder: Path) -> FitResult[Dynamics]:
    """Fit the simulator; curves and resume files go to `folder`. Validation is with people who are not trained on.

    An order of several stages (`stages`) shares the updates among them. Raises DataError for an order that
    the simulator cannot have.
    """
    config.check()
    torch.manual_seed(config.seed)
    dynamics = build_dynamics(config.spec())
    dynamics.fit_normaliser(torch.from_numpy(data.after - data.before), torch.from_numpy(data.constants[data.maps]))
    random = np.random.default_rng(config.seed)
    train, held_out = split_rows(data.episodes, data.people, config.held_out, config.seed)
    held_out = random.permutation(held_out)[:VALIDATION_ROWS]
    updates = -(-config.epochs * len(train) // config.batch) if config.epochs else config.updates
    fits = stages(config.order)
    done = made = 0
    for stage in fits:

        def draw() -> Batch:
            return _batch(data, random.choice(train, config.batch), torch.device("cpu"))

        def losses(network: nn.Module, *batch: Tensor, stage: FitStage = stage) -> Losses:
            assert isinstance(network, Dynamics)
            state, of_map, actions, after = batch
            return stage.losses(network, (state, of_map, actions, after))

        stage.prepare(dynamics)
        validate = partial(_validation, data, held_out)
        task = TrainingTask(dynamics, losses, validate, -(-updates // len(fits)), random, len(train), draw)
        trained = fit(task, config, folder / stage.name)
        assert isinstance(trained.network, Dynamics)
        dynamics = trained.network.cpu().requires_grad_(True)
        done, made = done + trained.updates, made + trained.made
    return FitResult(dynamics.requires_grad_(False), done, made)


def _validation(data: Transitions, held_out: Indices, network: nn.Module) -> Losses:
    """How far single ticks are predicted wrong, and the share of presses after which both hands are as predicted."""
    assert isinstance(network, Dynamics)
    state, of_map, actions, after = _batch(data, held_out, network.scale.device)
    error = network.advance(state, of_map, actions) - after
    found = {"l2": error.norm(dim=1).mean(), "items": error[:, ITEMS_START:].abs().max(dim=1).values.mean()}
    presses = data.presses(held_out)
    if len(presses):
        state, of_map, actions, after = _batch(data, presses, network.scale.device)
        right = hands_of(network.advance(state, of_map, actions)) == hands_of(after)
        found["presses"] = right.flatten(1).all(dim=1).double().mean()
    return found


def _batch(data: Transitions, rows: Indices, device: torch.device) -> Batch:
    arrays = data.before[rows], data.constants[data.maps[rows]], data.actions[rows], data.after[rows]
    before, constants, actions, after = (torch.from_numpy(array).to(device) for array in arrays)
    return before, constants, actions, after


@dataclass(frozen=True, slots=True)
class FitStage:
    """One fit: the losses of a batch, and what happens to the network before."""

    name: str  # of its folder; "" for the run folder itself
    losses: Callable[[Dynamics, Batch], Losses]
    prepare: Callable[[Dynamics], None] = lambda dynamics: None


def stages(order: Order) -> tuple[FitStage, ...]:
    """The fits of an order, one after the other; all but `joint` are for autoencoders.

    `joint` fits everything together, `fine-tuned` starts the second autoencoder from the weights of the first,
    `separate` fits both alone; with the last two the step between the latent spaces comes at the end, the autoencoders
    frozen.
    """
    joint = FitStage("", lambda network, batch: network.losses(*batch))
    if order == "joint":
        return (joint,)
    step = FitStage("step", lambda network, batch: {"loss": _vae(network).stepping(*batch)}, _freeze)
    if order == "separate":
        return FitStage("autoencoders", _both), step
    return FitStage("first", _first), FitStage("second", _second, _begin_second), step


def _first(network: Dynamics, batch: Batch) -> Losses:
    state, constant, _, _ = batch
    return {"loss": _vae(network).autoencoding(_vae(network).now, state, constant)}


def _second(network: Dynamics, batch: Batch) -> Losses:
    state, constant, _, after = batch
    vae = _vae(network)
    return {"loss": vae.autoencoding(vae.next, vae.target(state, after), constant)}


def _both(network: Dynamics, batch: Batch) -> Losses:
    first, second = _first(network, batch)["loss"], _second(network, batch)["loss"]
    return {"loss": first + second, "first": first, "second": second}


def _begin_second(network: Dynamics) -> None:
    vae = _vae(network)
    vae.next.load_state_dict(vae.now.state_dict())


def _freeze(network: Dynamics) -> None:
    for autoencoder in (_vae(network).now, _vae(network).next):
        autoencoder.requires_grad_(False)


def _vae(network: Dynamics) -> VaeDynamics:
    assert isinstance(network, VaeDynamics)
    return network
