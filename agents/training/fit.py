"""The training loop, resumable, the same for all networks.

A task brings the network and its batches; the loop has optimiser, moving average, precision, curves and the files of a
run folder.
"""

import contextlib
import copy
import json
import math
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, TypeVar

import numpy as np
import torch
from rich.console import Console
from safetensors import SafetensorError
from safetensors.torch import load_file
from torch import Tensor, nn
from torch.utils.tensorboard import SummaryWriter

from movingout.agents.errors import DataError
from movingout.agents.training.display import TrainingDisplay
from movingout.agents.training.gradients import Gradients, Losses
from movingout.agents.training.optimisation import WORTH_COMPILING, Optimisation
from movingout.agents.training.run_folder import RESUME
from movingout.agents.training.run_output import append_losses, cut_losses, save_tensors, written

NetworkT = TypeVar("NetworkT", bound=nn.Module, covariant=True)
SEED_STRIDE = 1_000_003  # between the seeds of two runs, more than a run has updates
SAVE_SECONDS = 300.0  # at most so much is lost of a training that is stopped, however slow its updates are


@dataclass(frozen=True, slots=True)
class TrainingTask:
    """What is fitted: a network, the losses of a batch by name (`loss` is minimised), and those of validation.

    `losses` and `validate` are given a network that may be on a GPU. A batch that `draw` returns is on the CPU, always
    of the same shapes, and is moved there; tasks without `draw` draw in `losses`, and move what they drew themselves.
    """

    network: nn.Module
    losses: Callable[..., Losses]  # of the network and the tensors of a batch
    validate: Callable[[nn.Module], Losses]
    updates: int
    random: np.random.Generator  # draws the batches; noise is drawn by torch
    rows: int  # that batches are drawn from
    draw: Callable[[], tuple[Tensor, ...]] | None = None


@dataclass(frozen=True, slots=True)
class FitResult(Generic[NetworkT]):
    """The moving average of the network, the total number of updates, and those made in this run."""

    network: NetworkT
    updates: int
    made: int


@dataclass(slots=True)
class _State:
    """Everything that changes during training."""

    network: nn.Module
    average: nn.Module
    optimiser: torch.optim.Optimizer
    gradients: Gradients
    update: int = 0


def fit(task: TrainingTask, config: Optimisation, folder: Path) -> FitResult[nn.Module]:
    """Train to the end, continuing from the folder's resume file if there is one.

    An interrupted run arrives at the same weights as an uninterrupted one. With another number of rows or another seed,
    random numbers start again from the seed. Writes TensorBoard events, `losses.jsonl` and the resume file; raises
    DataError where they cannot be written.
    """
    torch.set_num_threads(config.threads)
    device = torch.device("cuda" if torch.cuda.is_available() else "cpu")
    is_compiled = _is_compiled(task, config, device)
    state = _new_state(task, config, device, is_compiled)
    folder.mkdir(parents=True, exist_ok=True)
    torch.manual_seed(config.seed * SEED_STRIDE)
    _resume(state, task, config, folder / RESUME)
    cut_losses(folder, "update", state.update)
    console = Console(stderr=True, soft_wrap=True, highlight=False)
    if state.update >= task.updates:
        console.print(f"{folder}: already trained {state.update} updates; nothing is left to do", markup=False)
    begun_at, begun = state.update, time.monotonic()
    saved = begun
    with (
        _events(folder) as writer,
        TrainingDisplay(task.updates, begun_at, console) as display,
        _as_it_is() if is_compiled else contextlib.nullcontext(),
    ):
        while state.update < task.updates:
            losses = _update(state, task, config)
            display.show(state.update, losses["loss"].item)
            is_evaluated = state.update % config.evaluate_every == 0 or state.update == task.updates
            if is_evaluated:
                values = _evaluated(state, task, losses)
                _log_losses(folder, writer, state.update, time.monotonic() - begun, values)
                display.evaluated(values["loss"])
            if is_evaluated or time.monotonic() - saved >= SAVE_SECONDS:
                _save(state, task, config, folder / RESUME)
                saved = time.monotonic()
    return FitResult(state.average.eval(), state.update, state.update - begun_at)


def _new_state(task: TrainingTask, config: Optimisation, device: torch.device, is_compiled: bool) -> _State:
    """Before the first update, with the network on `device`."""
    network = task.network.to(device)
    optimiser = torch.optim.AdamW(
        network.parameters(), lr=config.rate, weight_decay=config.decay, fused=device.type == "cuda"
    )
    mixed = config.precision == "bf16" or (config.precision == "auto" and _faster_in_bf16(device))
    gradients = Gradients(network, _compiled(task.losses) if is_compiled else task.losses, task.draw, device, mixed)
    return _State(network, _copied(network), optimiser, gradients)


def _log_losses(folder: Path, writer: SummaryWriter, update: int, seconds: float, values: dict[str, float]) -> None:
    """To TensorBoard and `losses.jsonl`; `seconds` since this run began. Raises DataError if they cannot be written."""
    with written(folder):
        for name, value in values.items():
            writer.add_scalar(name, value, update)
    append_losses(folder, {"update": update, "seconds": round(seconds, 1), **values})


@contextlib.contextmanager
def _events(folder: Path) -> Iterator[SummaryWriter]:
    """TensorBoard's file. Raises DataError where it cannot be written."""
    with _quiet_writer():
        with written(folder):
            writer = SummaryWriter(str(folder))
        try:
            yield writer
        finally:
            with written(folder):
                writer.close()


@contextlib.contextmanager
def _quiet_writer() -> Iterator[None]:
    """TensorBoard's thread prints no traceback where it cannot write: what it raised comes with the next call."""
    before = threading.excepthook

    def tell(failed: threading.ExceptHookArgs) -> None:
        if not (isinstance(failed.exc_value, OSError) and type(failed.thread).__module__.startswith("tensorboard.")):
            before(failed)

    threading.excepthook = tell
    try:
        yield
    finally:
        threading.excepthook = before


def _is_compiled(task: TrainingTask, config: Optimisation, device: torch.device) -> bool:
    if task.draw is None:  # drawing cannot be compiled
        return False
    if config.compile == "auto":
        return device.type == "cuda" and task.updates >= WORTH_COMPILING
    return config.compile == "yes"


def _compiled(losses: Callable[..., Losses]) -> Callable[..., Losses]:
    """The same losses in fewer kernels."""
    torch._dynamo.reset()  # what earlier trainings of this process compiled counts against a limit
    compiled: Callable[..., Losses] = torch.compile(losses, dynamic=False)
    return compiled


def _as_it_is() -> contextlib.AbstractContextManager[None]:
    """What cannot be compiled runs as it is."""
    patched: contextlib.AbstractContextManager[None] = torch._dynamo.config.patch(suppress_errors=True)
    return patched


def _copied(network: nn.Module) -> nn.Module:
    """A copy for the moving average; recurrent layers have their weights in one piece again, as a GPU wants them."""
    copied = copy.deepcopy(network).requires_grad_(False)
    for layer in copied.modules():
        if isinstance(layer, nn.RNNBase):
            layer.flatten_parameters()
    return copied


def _update(state: _State, task: TrainingTask, config: Optimisation) -> Losses:
    """One gradient step."""
    for group in state.optimiser.param_groups:
        group["lr"] = config.rate * _schedule(state.update, task.updates, config.warmup)
    state.network.train()
    losses = state.gradients()
    if config.clip:
        nn.utils.clip_grad_norm_(state.network.parameters(), config.clip)
    state.optimiser.step()
    state.update += 1
    keep = min(config.ema, (1 + state.update) / (10 + state.update))
    _average(state, keep)
    return losses


def _faster_in_bf16(device: torch.device) -> bool:
    """Whether the device has instructions for bf16; without them a CPU converts back and forth and is slower."""
    if device.type == "cuda":
        return True
    return bool(torch.cpu._is_avx512_bf16_supported() or torch.cpu._is_amx_tile_supported())


@torch.no_grad()
def _average(state: _State, keep: float) -> None:
    """Update the moving average; buffers (normalisation) are copied."""
    torch._foreach_lerp_(list(state.average.parameters()), list(state.network.parameters()), 1 - keep)
    for target, source in zip(state.average.buffers(), state.network.buffers(), strict=True):
        target.copy_(source)


def _schedule(update: int, updates: int, warmup: int) -> float:
    """Linear warm-up, then half a cosine to 0."""
    if update < warmup:
        return (update + 1) / warmup
    return 0.5 * (1 + math.cos(math.pi * (update - warmup) / max(updates - warmup, 1)))


def _evaluated(state: _State, task: TrainingTask, losses: Losses) -> dict[str, float]:
    """The last losses and the validation losses. Raises DataError when one is not finite."""
    state.average.eval()
    with torch.inference_mode():
        validation = {f"validation/{name}": value for name, value in task.validate(state.average).items()}
    values = {name: float(value.detach()) for name, value in {**losses, **validation}.items()}
    if not all(math.isfinite(value) for value in values.values()):
        raise DataError(f"training diverged at update {state.update}: {values}; try a lower --rate")
    return values


def _save(state: _State, task: TrainingTask, config: Optimisation, path: Path) -> None:
    """Save everything needed to continue, as plain tensors."""
    tensors = {f"network.{name}": tensor for name, tensor in state.network.state_dict().items()}
    tensors |= {f"average.{name}": tensor for name, tensor in state.average.state_dict().items()}
    for index, entries in state.optimiser.state_dict()["state"].items():
        tensors |= {f"optimiser.{index}.{name}": torch.as_tensor(value) for name, value in entries.items()}
    tensors |= {"update": torch.tensor(state.update), "drawn": torch.tensor([config.seed, task.rows])}
    tensors |= {f"random.{name}": drawn for name, drawn in _random_state(task.random).items()}
    save_tensors(path, {name: tensor.clone().contiguous() for name, tensor in tensors.items()})


def _resume(state: _State, task: TrainingTask, config: Optimisation, path: Path) -> None:
    """Load what `_save` wrote. Raises DataError when it is damaged or of another network."""
    if not path.exists():
        return
    entries: dict[int, dict[str, Tensor]] = {}
    try:
        tensors = load_file(path)
        state.network.load_state_dict(_under(tensors, "network."))
        state.average.load_state_dict(_under(tensors, "average."))
        state.update = int(tensors["update"])
        if "drawn" in tensors and tensors["drawn"].tolist() == [config.seed, task.rows]:
            _restore_random(task.random, _under(tensors, "random."))
        else:
            torch.manual_seed(config.seed * SEED_STRIDE + state.update)
    except (OSError, SafetensorError, KeyError, RuntimeError, ValueError, TypeError) as error:
        raise DataError(f"{path} is damaged or of another network; choose another --id") from error
    for name, tensor in _under(tensors, "optimiser.").items():
        index, _, key = name.partition(".")
        entries.setdefault(int(index), {})[key] = tensor
    state.optimiser.load_state_dict({**state.optimiser.state_dict(), "state": entries})


def _random_state(random: np.random.Generator) -> dict[str, Tensor]:
    """The state of all random number generators."""
    numpy_state = json.dumps(random.bit_generator.state).encode()
    state = {"torch": torch.get_rng_state(), "numpy": torch.frombuffer(bytearray(numpy_state), dtype=torch.uint8)}
    return {**state, "cuda": torch.cuda.get_rng_state()} if torch.cuda.is_available() else state


def _restore_random(random: np.random.Generator, state: dict[str, Tensor]) -> None:
    """Restore the generators. Raises KeyError, RuntimeError or ValueError for an invalid state."""
    random.bit_generator.state = json.loads(bytes(state["numpy"].tolist()))
    torch.set_rng_state(state["torch"])
    if "cuda" in state and torch.cuda.is_available():
        torch.cuda.set_rng_state(state["cuda"])


def _under(tensors: dict[str, Tensor], prefix: str) -> dict[str, Tensor]:
    return {name.removeprefix(prefix): tensor for name, tensor in tensors.items() if name.startswith(prefix)}
