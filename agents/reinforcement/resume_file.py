"""What reinforcement learning keeps to continue: networks, the state of their optimiser, and further tensors."""

from collections.abc import Mapping
from pathlib import Path

import torch
from safetensors import SafetensorError
from safetensors.torch import load_file
from torch import Tensor, nn

from movingout.agents.errors import DataError
from movingout.agents.training.run_output import save_tensors

Tensors = dict[str, Tensor]


def write_resume(
    path: Path, learned: nn.Module, optimiser: torch.optim.Optimizer, others: Mapping[str, Tensor]
) -> None:
    """Write everything, as plain tensors. Raises DataError."""
    tensors = {f"learned.{name}": tensor.clone() for name, tensor in learned.state_dict().items()}
    for index, entries in optimiser.state_dict()["state"].items():
        tensors |= {f"optimiser.{index}.{name}": torch.as_tensor(value).clone() for name, value in entries.items()}
    save_tensors(path, {**tensors, **others})


def read_resume(path: Path, learned: nn.Module, optimiser: torch.optim.Optimizer) -> Tensors:
    """Put networks and optimiser back, and return the further tensors.

    Raises DataError when the file is damaged, or of other networks.
    """
    try:
        tensors = load_file(path)
        learned.load_state_dict(_under("learned.", tensors))
    except (OSError, SafetensorError, KeyError, RuntimeError) as error:
        raise DataError(f"{path} is damaged or of another policy; choose another --id") from error
    states: dict[int, Tensors] = {}
    for name, tensor in _under("optimiser.", tensors).items():
        index, key = name.split(".", 1)
        states.setdefault(int(index), {})[key] = tensor
    optimiser.load_state_dict({**optimiser.state_dict(), "state": states})
    return {name: one for name, one in tensors.items() if not name.startswith(("learned.", "optimiser."))}


def _under(prefix: str, tensors: Mapping[str, Tensor]) -> Tensors:
    return {name.removeprefix(prefix): one for name, one in tensors.items() if name.startswith(prefix)}
