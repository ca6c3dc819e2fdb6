"""In which order the parts of the learned simulator are fitted (paper, "BASS Details").

`joint` fits everything together, `fine-tuned` begins the second autoencoder where the first has ended, `separate`
fits both alone; with the last two the step between the latent spaces comes at the end, the autoencoders frozen.
"""

from collections.abc import Callable
from dataclasses import dataclass

from torch import Tensor

from movingout.agents.bass.dynamics import Dynamics, VaeDynamics
from movingout.agents.training.config import Order
from movingout.agents.training.loop import Losses

Batch = tuple[Tensor, Tensor, Tensor, Tensor]
"""States (B, 58), constants (B, 146), actions (B, 8), next states (B, 58)."""


@dataclass(frozen=True, slots=True)
class Stage:
    """One fit: the losses of a batch, and what happens to the network before."""

    name: str  # of its folder; "" for the run folder itself
    losses: Callable[[Dynamics, Batch], Losses]
    prepare: Callable[[Dynamics], None] = lambda dynamics: None


def stages(order: Order) -> tuple[Stage, ...]:
    """The fits of an order, one after the other; all but `joint` are for autoencoders."""
    joint = Stage("", lambda network, batch: network.losses(*batch))
    if order == "joint":
        return (joint,)
    step = Stage("step", lambda network, batch: {"loss": _vae(network).stepping(*batch)}, _freeze)
    if order == "separate":
        return Stage("autoencoders", _both), step
    return Stage("first", _first), Stage("second", _second, _begin_second), step


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
