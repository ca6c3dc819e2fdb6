"""Training the learned simulator from episodes, and adding it to a policy to make a BASS agent."""

from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import torch
from safetensors.torch import save
from torch import nn

from movingout.agents.bass.dynamics import Dynamics, Rollout, build_dynamics
from movingout.agents.bass.grasp_model import hands_of
from movingout.agents.bass.state_vector import (
    ACTION_WIDTH,
    CONSTANT_WIDTH,
    ITEMS_START,
    MOVING_WIDTH,
    constant,
    moving_arrays,
)
from movingout.agents.checkpoint.checkpoint import Checkpoint, DynamicsSpec, FileName, Training, write_checkpoint
from movingout.agents.checkpoint.policy_spec import Grasp
from movingout.agents.data.dataset import Indices, Singles, Trajectory, split_rows
from movingout.agents.errors import CheckpointError
from movingout.agents.policies.export import export, halved_weights
from movingout.agents.training.config import BassConfig
from movingout.agents.training.loop import Fitted, Losses, Task, fit
from movingout.agents.training.stages import Batch, Stage, stages
from movingout.agents.training.values import ValueFile
from movingout.maps import MapSpec

VALIDATION_ROWS = 8192


@dataclass(frozen=True, slots=True, eq=False)
class Transitions:
    """Single ticks of many episodes."""

    before: Singles  # (M, 58)
    actions: Singles  # (M, 8) distance, cos, sin, toggle of blue and red
    after: Singles  # (M, 58)
    maps: Indices  # (M,) row of `constants`
    constants: Singles  # (K, 146)
    episodes: Indices  # (M,) number of the episode
    casts: tuple[frozenset[str], ...]  # (E,) who is in each episode

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
    for number, walk in enumerate(trajectories):
        rows = moving_arrays(walk.robot_poses, walk.robot_velocities, walk.held, walk.item_poses)
        index = maps.setdefault(walk.map, len(maps))
        pieces.append((rows[:-1], action_rows(walk), rows[1:], np.full((walk.ticks, 2), (index, number))))
    before, actions, after, numbers = (np.concatenate(part) for part in zip(*pieces, strict=True))
    return Transitions(
        before.astype(np.float32),
        actions.astype(np.float32),
        after.astype(np.float32),
        numbers[:, 0],
        np.array([constant(the_map) for the_map in maps], dtype=np.float32),
        numbers[:, 1],
        tuple(walk.cast for walk in trajectories),
    )


def action_rows(walk: Trajectory) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """(T, 8): world actions as distance, cos, sin, toggle of blue and red."""
    distance, heading, toggle = (walk.actions[..., k] for k in range(3))
    rows = np.stack((distance, np.cos(heading), np.sin(heading), toggle > 0.5), axis=-1)
    return rows.reshape(len(rows), -1)


def train_dynamics(config: BassConfig, data: Transitions, folder: Path) -> Fitted[Dynamics]:
    """Fit the simulator; curves and resume files go to `folder`. Validation is with people who are not trained on.

    An order of several stages (`training.stages`) shares the updates among them. Raises DataError for an order that
    the simulator cannot have.
    """
    config.check()
    torch.manual_seed(config.seed)
    dynamics = build_dynamics(config.spec())
    dynamics.fit_normaliser(torch.from_numpy(data.after - data.before), torch.from_numpy(data.constants[data.maps]))
    random = np.random.default_rng(config.seed)
    train, held_out = split_rows(data.episodes, data.casts, config.held_out, config.seed)
    held_out = random.permutation(held_out)[:VALIDATION_ROWS]
    updates = -(-config.epochs * len(train) // config.batch) if config.epochs else config.updates
    fits = stages(config.order)
    done = made = 0
    for stage in fits:

        def losses(network: nn.Module, stage: Stage = stage) -> Losses:
            assert isinstance(network, Dynamics)
            return stage.losses(network, _batch(data, random.choice(train, config.batch), network.scale.device))

        stage.prepare(dynamics)
        validate = partial(_validation, data, held_out)
        task = Task(dynamics, losses, validate, -(-updates // len(fits)), random, len(train))
        trained = fit(task, config, folder / stage.name)
        assert isinstance(trained.network, Dynamics)
        dynamics = trained.network.cpu().requires_grad_(True)
        done, made = done + trained.updates, made + trained.made
    return Fitted(dynamics.requires_grad_(False), done, made)


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


def export_dynamics(dynamics: Dynamics, depth: int, grasp: Grasp) -> bytes:
    """ONNX of `state` (B, 58), `constant` (B, 146), `actions` (B, depth, 2, 4) to `states` (B, depth, 58)."""
    example = torch.zeros(2, MOVING_WIDTH), torch.zeros(2, CONSTANT_WIDTH), torch.zeros(2, depth, 2, 4)
    return export(Rollout(dynamics, depth, grasp), example, ["state", "constant", "actions"], ["states"])


@dataclass(frozen=True, slots=True)
class Simulator:
    """A trained simulator as it lies in a checkpoint."""

    spec: DynamicsSpec
    onnx: bytes
    weights: bytes  # safetensors
    training: Training | None  # where the weights come from; older cards do not say it


def exported(dynamics: Dynamics, depth: int, grasp: Grasp, training: Training) -> Simulator:
    """The files of a trained simulator."""
    return Simulator(dynamics.spec, export_dynamics(dynamics, depth, grasp), save(halved_weights(dynamics)), training)


def simulator_of(checkpoint: Checkpoint, depth: int, grasp: Grasp) -> Simulator:
    """The simulator of another BASS agent. Raises CheckpointError when it is none, or one for other chunks."""
    card = checkpoint.card
    if card.dynamics is None or card.selection is None:
        raise CheckpointError(f"{card.id} has no simulator; name an agent of kind bass")
    if (card.selection.depth, card.policy.grasp) != (depth, grasp):
        raise CheckpointError(
            f"the simulator of {card.id} is for {card.selection.depth} ticks and grasp {card.policy.grasp}, "
            f"not for {depth} and {grasp}"
        )
    onnx, weights = checkpoint.read("dynamics.onnx"), checkpoint.read("dynamics.safetensors")
    return Simulator(card.dynamics, onnx, weights, card.dynamics_training)


def save_bass(
    folder: Path, agent_id: str, base: Checkpoint, simulator: Simulator, value: ValueFile | None, config: BassConfig,
    name: str, description: str,
) -> Checkpoint:  # fmt: skip
    """Write the checkpoint of a BASS agent: the base policy's network, the simulator and, if it has one, the value."""
    card = {
        **base.card.model_dump(exclude={"files", "scores"}),
        "id": agent_id,
        "name": name,
        "description": description,
        "kind": "bass",
        "dynamics": simulator.spec.model_dump(),
        "selection": config.selection().model_dump(),
        "value": value.spec.model_dump() if value else None,
        "dynamics_training": simulator.training.model_dump() if simulator.training else None,
        "value_training": value.training.model_dump() if value and value.training else None,
    }
    files: dict[FileName, bytes] = {
        "policy.onnx": base.read("policy.onnx"),
        "dynamics.onnx": simulator.onnx,
        "dynamics.safetensors": simulator.weights,
    }
    if value:
        files |= {"value.onnx": value.onnx}
    return write_checkpoint(folder, card, files)
