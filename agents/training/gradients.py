"""Losses and gradients of a batch: step by step on a CPU, in one launch on a GPU.

The networks are small, so that a GPU waits for a CPU that launches their kernels one by one. Recorded once as a CUDA
graph, all kernels of a batch are launched together.
"""

from collections.abc import Callable

import torch
from torch import Tensor, nn

Losses = dict[str, Tensor]
WARM_UP = 3  # batches before a graph is recorded, as torch asks for


class Gradients:
    """Each call draws a batch and leaves the gradients of its `loss` in the network's parameters."""

    def __init__(
        self, network: nn.Module, losses: Callable[..., Losses], draw: Callable[[], tuple[Tensor, ...]] | None,
        device: torch.device, mixed: bool,
    ) -> None:  # fmt: skip
        """`mixed`: whether products are computed in bf16."""
        self._network, self._losses, self._draw = network, losses, draw
        self._device, self._mixed = device, mixed
        self._recorded: _Recorded | None = None

    def __call__(self) -> Losses:
        """The losses of the batch."""
        if self._draw is None:
            return self._computed(())
        batch = self._draw()
        if self._device.type != "cuda":
            return self._computed(batch)
        if self._recorded is None:
            self._recorded = _Recorded(self._computed, [part.to(self._device) for part in batch])
        return self._recorded.replayed(batch)

    def _computed(self, batch: tuple[Tensor, ...]) -> Losses:
        self._network.zero_grad(set_to_none=True)
        with torch.autocast(self._device.type, torch.bfloat16, self._mixed):
            losses = self._losses(self._network, *batch)
        losses["loss"].backward()  # type: ignore[no-untyped-call]
        return losses


class _Recorded:
    """The graph of a computation on a GPU, and the tensors that it reads and writes."""

    def __init__(self, compute: Callable[[tuple[Tensor, ...]], Losses], batch: list[Tensor]) -> None:
        """Random numbers are drawn as if nothing had been tried, so that a continued run does as one in one go."""
        self._batch = tuple(batch)
        drawn = torch.cuda.get_rng_state()
        aside = torch.cuda.Stream()  # type: ignore[no-untyped-call]
        aside.wait_stream(torch.cuda.current_stream())
        with torch.cuda.stream(aside):
            for _ in range(WARM_UP):
                compute(self._batch)
        torch.cuda.current_stream().wait_stream(aside)
        self._graph = torch.cuda.CUDAGraph()
        with torch.cuda.graph(self._graph):
            self._losses = compute(self._batch)
        torch.cuda.set_rng_state(drawn)

    def replayed(self, batch: tuple[Tensor, ...]) -> Losses:
        """The losses of another batch."""
        for there, part in zip(self._batch, batch, strict=True):
            there.copy_(part.pin_memory(), non_blocking=True)
        self._graph.replay()
        return self._losses
