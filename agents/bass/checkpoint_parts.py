"""The networks that BASS has beside its base policy, as files of a checkpoint: the simulator and the value."""

from dataclasses import dataclass
from pathlib import Path

import torch
from safetensors.torch import save

from movingout.agents.bass.config import BassConfig
from movingout.agents.bass.dynamics import Dynamics, Rollout
from movingout.agents.bass.latent.picture_networks import PictureDynamics, PictureProgress, example_picture
from movingout.agents.bass.progress_training import ProgressNetwork
from movingout.agents.bass.state_vector import CONSTANT_WIDTH, MOVING_WIDTH
from movingout.agents.bass.value_training import ValueNetwork
from movingout.agents.checkpoint.card import DynamicsSpec, FileName, ProgressSpec, Training, ValueSpec
from movingout.agents.checkpoint.checkpoint import Checkpoint, write_checkpoint
from movingout.agents.checkpoint.policy_spec import Grasp
from movingout.agents.errors import CheckpointError
from movingout.agents.policies.export import export, halved_weights

_WEIGHTS = "dynamics.safetensors"
_STATE = {
    "state": "the moving part of a state: agents/bass/state_vector.py",
    "constant": "its constant part: items, walls and goals",
}
_PICTURE = {"picture": "an observation in layout image-v1"}
_EMBEDDING = {"embedding": "its distance from that of the first state is the progress"}


@dataclass(frozen=True, slots=True)
class TrainedSimulator:
    """A trained simulator as it lies in a checkpoint."""

    spec: DynamicsSpec
    onnx: bytes
    weights: bytes | None  # safetensors, for other tools; agents that came with a wheel lack them
    training: Training | None  # where the weights come from; older cards do not say


@dataclass(frozen=True, slots=True)
class TrainedValue:
    """A trained value network as it lies in a checkpoint."""

    spec: ValueSpec
    onnx: bytes
    training: Training | None  # where the weights come from; older cards do not say


@dataclass(frozen=True, slots=True)
class TrainedProgress:
    """A trained embedding of progress as it lies in a checkpoint."""

    spec: ProgressSpec
    onnx: bytes
    training: Training | None


def export_dynamics(dynamics: Dynamics, depth: int, grasp: Grasp) -> bytes:
    """ONNX of `state` (B, 58), `constant` (B, 146), `actions` (B, depth, 2, 4) to `states` (B, depth, 58)."""
    example = torch.zeros(2, MOVING_WIDTH), torch.zeros(2, CONSTANT_WIDTH), torch.zeros(2, depth, 2, 4)
    inputs = {
        **_STATE,
        "actions": "per tick, of blue and red: distance, cos and sin of the heading, grasp as the policy writes it",
    }
    about = {"network": "dynamics", "depth": depth, "grasp": grasp, **dynamics.spec.model_dump()}
    outputs = {"states": "the moving part after each tick"}
    return export(Rollout(dynamics, depth, grasp), example, inputs, outputs, about)


def packed_simulator(dynamics: Dynamics, depth: int, grasp: Grasp, training: Training) -> TrainedSimulator:
    """A simulator that was trained just now."""
    onnx, weights = export_dynamics(dynamics, depth, grasp), save(halved_weights(dynamics))
    return TrainedSimulator(dynamics.spec, onnx, weights, training)


def packed_value(network: ValueNetwork, training: Training) -> TrainedValue:
    """A value network that was trained just now."""
    example = torch.zeros(2, len(network.mean))
    inputs = {"features": f"an observation in layout {network.spec.layout}, not normalised"}
    outputs = {"value": "discounted progress that is expected to follow"}
    about = {"network": "value", **network.spec.model_dump()}
    return TrainedValue(network.spec, export(network, (example,), inputs, outputs, about), training)


def packed_progress(network: ProgressNetwork, training: Training) -> TrainedProgress:
    """An embedding that was trained just now."""
    example = torch.zeros(2, MOVING_WIDTH), torch.zeros(2, CONSTANT_WIDTH)
    about = {"network": "progress", **network.spec.model_dump()}
    return TrainedProgress(network.spec, export(network, example, _STATE, _EMBEDDING, about), training)


def packed_picture_simulator(dynamics: PictureDynamics, depth: int, training: Training) -> TrainedSimulator:
    """ONNX of `picture` (B, D) and `actions` (B, depth, 2, 4), the own ones first, to the `after` picture (B, D)."""
    example = example_picture(dynamics.shape), torch.zeros(2, depth, 2, 4)
    inputs = {**_PICTURE, "actions": "per tick, of oneself and the partner: distance, cos, sin, grasp"}
    about = {"network": "dynamics", "depth": depth, **dynamics.spec.model_dump()}
    onnx = export(dynamics, example, inputs, {"after": "the picture after these ticks"}, about)
    return TrainedSimulator(dynamics.spec, onnx, save(halved_weights(dynamics)), training)


def packed_picture_progress(network: PictureProgress, training: Training) -> TrainedProgress:
    """ONNX of `picture` (B, D) to its `embedding` (B, Z)."""
    about = {"network": "progress", **network.spec.model_dump()}
    onnx = export(network, (example_picture(network.shape),), _PICTURE, _EMBEDDING, about)
    return TrainedProgress(network.spec, onnx, training)


def simulator_of(checkpoint: Checkpoint, depth: int, grasp: Grasp) -> TrainedSimulator:
    """The simulator of another BASS agent. Raises CheckpointError when it has none, or one for other chunks."""
    card = checkpoint.card
    if card.dynamics is None or card.selection is None:
        raise CheckpointError(f"{card.id} has no learned simulator; name another agent of kind bass")
    if (card.selection.depth, card.network.grasp) != (depth, grasp):
        raise CheckpointError(
            f"the simulator of {card.id} is for {card.selection.depth} ticks and grasp {card.network.grasp}, "
            f"not for {depth} and {grasp}"
        )
    weights = checkpoint.read(_WEIGHTS) if checkpoint.has(_WEIGHTS) else None
    return TrainedSimulator(card.dynamics, checkpoint.read("dynamics.onnx"), weights, card.dynamics_training)


def value_of(checkpoint: Checkpoint) -> TrainedValue:
    """The value network of another BASS agent. Raises CheckpointError when it has none."""
    card = checkpoint.card
    if card.value is None:
        raise CheckpointError(f"{card.id} has no value network; name an agent trained with --score value")
    return TrainedValue(card.value, checkpoint.read("value.onnx"), card.value_training)


def save_bass(
    folder: Path, agent_id: str, base: Checkpoint, simulator: TrainedSimulator | None, value: TrainedValue | None,
    config: BassConfig, name: str, description: str, progress: TrainedProgress | None = None,
) -> Checkpoint:  # fmt: skip
    """Write the checkpoint of a BASS agent: the base policy's network, and its other networks if any."""
    card = {
        **base.card.model_dump(exclude={"files", "scores"}),
        "id": agent_id,
        "name": name,
        "description": description,
        "kind": "bass",
        "dynamics": simulator.spec.model_dump() if simulator else None,
        "selection": config.selection().model_dump(),
        "value": value.spec.model_dump() if value else None,
        "dynamics_training": simulator.training.model_dump() if simulator and simulator.training else None,
        "progress": progress.spec.model_dump() if progress else None,
        "progress_training": progress.training.model_dump() if progress and progress.training else None,
        "value_training": value.training.model_dump() if value and value.training else None,
    }
    files: dict[FileName, bytes] = {"policy.onnx": base.read("policy.onnx")}
    if simulator:
        files |= {"dynamics.onnx": simulator.onnx}
    if simulator and simulator.weights:
        files |= {_WEIGHTS: simulator.weights}
    if value:
        files |= {"value.onnx": value.onnx}
    if progress:
        files |= {"progress.onnx": progress.onnx}
    return write_checkpoint(folder, card, files)
