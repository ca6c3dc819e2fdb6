"""The learned simulator: two variational autoencoders and a step between their latent spaces (paper, "BASS Details").

    z_t = encode_1(s_t)      z_{t+1} = f(z_t, a_t, a_t^p)      s_{t+1} = decode_2(z_{t+1})

The first autoencoder is of the present state, the second of the next state or, with `residual`, of the change of the
state, so that it need not reproduce what stays. Both and the latent step are trained together. `GruDynamics` and
`QvaeDynamics` are the paper's baselines.

With `rigid`, the network predicts robots and hands only: a held item moves rigidly with its holder (within 0.001 u per
tick of the engine, measured) and other items stay in place. With `grasping`, the effect of a press is computed instead
of predicted (`agents.bass.grasp_model`).
"""

import torch
from torch import Tensor, nn
from torch.nn import functional as F

from movingout.agents.bass.grasp_model import Grasping
from movingout.agents.bass.state_vector import (
    ACTION_WIDTH,
    CONSTANT_WIDTH,
    HELD_START,
    HELD_WIDTH,
    ITEMS_START,
    MOVING_WIDTH,
    ROBOT_WIDTH,
)
from movingout.agents.checkpoint.card import DynamicsKind, DynamicsSpec
from movingout.agents.checkpoint.policy_spec import Grasp

KL_WEIGHT = 1e-5
LATENT_WEIGHT = 0.1
RECONSTRUCTION_WEIGHT = 0.1
CODES, CODE_WIDTH, COMMITMENT = 256, 4, 0.25  # of the qVAE; the paper gives none


def _layers(inputs: int, width: int, outputs: int) -> nn.Sequential:
    return nn.Sequential(
        nn.Linear(inputs, width), nn.ReLU(), nn.Linear(width, width), nn.ReLU(), nn.Linear(width, outputs)
    )


class AutoEncoder(nn.Module):
    """A variational autoencoder of states, conditioned on the constants of the map."""

    def __init__(self, spec: DynamicsSpec) -> None:
        super().__init__()
        self.encoder = _layers(MOVING_WIDTH + CONSTANT_WIDTH, spec.width, 2 * spec.latent)
        self.decoder = _layers(spec.latent + CONSTANT_WIDTH, spec.width, MOVING_WIDTH)

    def encode(self, state: Tensor, constant: Tensor) -> tuple[Tensor, Tensor]:
        """Mean and log variance (B, Z)."""
        mean, log_variance = self.encoder(torch.cat((state, constant), dim=-1)).chunk(2, dim=-1)
        return mean, log_variance.clamp(-10.0, 4.0)

    def decode(self, latent: Tensor, constant: Tensor) -> Tensor:
        """(B, 58)."""
        out: Tensor = self.decoder(torch.cat((latent, constant), dim=-1))
        return out


def sampled(mean: Tensor, log_variance: Tensor) -> Tensor:
    """Drawn from normal distributions (B, Z)."""
    return mean + torch.randn_like(mean) * (0.5 * log_variance).exp()


def divergence_of(mean: Tensor, log_variance: Tensor) -> Tensor:
    """Of normal distributions (B, Z) from the standard one (Kullback-Leibler), mean over the batch."""
    return 0.5 * (mean**2 + log_variance.exp() - 1.0 - log_variance).sum(dim=-1).mean()


class Dynamics(nn.Module):
    """Predicts moving states. Normalisation is part of the network."""

    scale: Tensor
    constant_mean: Tensor
    constant_scale: Tensor
    learned: Tensor  # indices of the numbers of a state that the network predicts

    def __init__(self, spec: DynamicsSpec) -> None:
        super().__init__()
        self.spec = spec
        self.grasping = Grasping() if spec.grasping else None
        self.register_buffer("scale", torch.ones(MOVING_WIDTH))
        self.register_buffer("constant_mean", torch.zeros(CONSTANT_WIDTH))
        self.register_buffer("constant_scale", torch.ones(CONSTANT_WIDTH))
        hands = [] if spec.grasping else range(HELD_START, ITEMS_START)
        items = [] if spec.rigid else range(ITEMS_START, MOVING_WIDTH)
        learned = torch.tensor([*range(HELD_START), *hands, *items])
        self.register_buffer("learned", learned, persistent=False)

    def fit_normaliser(self, change: Tensor, constants: Tensor) -> None:
        """Take the size of changes (M, 58) and the spread of constants (M, 146) from training data."""
        if self.spec.residual:
            self.scale.copy_(change.std(dim=0).clamp(min=0.01))
        spread = constants.std(dim=0)
        self.constant_mean.copy_(constants.mean(dim=0))
        self.constant_scale.copy_(torch.where(spread > 1e-3, 1.0 / spread.clamp(min=1e-3), torch.ones_like(spread)))

    def of_map(self, constant: Tensor) -> Tensor:
        """Normalised constants."""
        return ((constant - self.constant_mean) * self.constant_scale).clamp(-4.0, 4.0)

    def advance(self, state: Tensor, constant: Tensor, actions: Tensor) -> Tensor:
        """The next moving state (B, 58), with one-hot hands, and items moved by their holders."""
        after = self.step(state, constant, actions)
        if self.grasping is None:
            after = tidied(after)
        else:
            hands = self.grasping(state, constant, actions.reshape(-1, 2, ACTION_WIDTH)[..., 3])
            after = torch.cat((after[:, :HELD_START], hands.flatten(1), after[:, ITEMS_START:]), dim=1)
        return carried(state, after) if self.spec.rigid else after

    def losses(self, state: Tensor, constant: Tensor, actions: Tensor, after: Tensor) -> dict[str, Tensor]:
        """Losses of single steps: states (B, 58), constants (B, 146), toggling actions (B, 8), next states (B, 58)."""
        raise NotImplementedError

    def step(self, state: Tensor, constant: Tensor, actions: Tensor) -> Tensor:
        """The next moving state (B, 58)."""
        raise NotImplementedError


class VaeDynamics(Dynamics):
    """The paper's simulator."""

    def __init__(self, spec: DynamicsSpec) -> None:
        super().__init__(spec)
        self.now = AutoEncoder(spec)
        self.next = AutoEncoder(spec)
        self.latent_step = _layers(spec.latent + 2 * ACTION_WIDTH, spec.width, spec.latent)

    def step(self, state: Tensor, constant: Tensor, actions: Tensor) -> Tensor:
        of_map = self.of_map(constant)
        mean, _ = self.now.encode(state, of_map)
        predicted = self.next.decode(self.latent_step(torch.cat((mean, actions), dim=-1)), of_map)
        return state + predicted * self.scale if self.spec.residual else predicted

    def losses(self, state: Tensor, constant: Tensor, actions: Tensor, after: Tensor) -> dict[str, Tensor]:
        of_map, target = self.of_map(constant), self.target(state, after)
        now_mean, now_variance = self.now.encode(state, of_map)
        next_mean, next_variance = self.next.encode(target, of_map)
        now = sampled(now_mean, now_variance)
        stepped = self.latent_step(torch.cat((now, actions), dim=-1))
        prediction = F.smooth_l1_loss(self.next.decode(stepped, of_map)[:, self.learned], target[:, self.learned])
        reconstruction = F.mse_loss(self.now.decode(now, of_map), state) + F.smooth_l1_loss(
            self.next.decode(sampled(next_mean, next_variance), of_map), target
        )
        latent = F.mse_loss(stepped, next_mean)
        divergence = divergence_of(now_mean, now_variance) + divergence_of(next_mean, next_variance)
        loss = prediction + RECONSTRUCTION_WEIGHT * reconstruction + LATENT_WEIGHT * latent + KL_WEIGHT * divergence
        return {"loss": loss, "prediction": prediction, "reconstruction": reconstruction, "latent": latent}

    def target(self, state: Tensor, after: Tensor) -> Tensor:
        """The input of the second autoencoder: the next state (B, 58), or its scaled change."""
        return (after - state) / self.scale if self.spec.residual else after

    def autoencoding(self, autoencoder: AutoEncoder, rows: Tensor, constant: Tensor) -> Tensor:
        """The loss of one autoencoder alone on its inputs (B, 58)."""
        of_map = self.of_map(constant)
        mean, variance = autoencoder.encode(rows, of_map)
        rebuilt = autoencoder.decode(sampled(mean, variance), of_map)
        return F.smooth_l1_loss(rebuilt, rows) + KL_WEIGHT * divergence_of(mean, variance)

    def stepping(self, state: Tensor, constant: Tensor, actions: Tensor, after: Tensor) -> Tensor:
        """The loss of the latent step alone."""
        of_map = self.of_map(constant)
        now, _ = self.now.encode(state, of_map)
        then, _ = self.next.encode(self.target(state, after), of_map)
        return F.mse_loss(self.latent_step(torch.cat((now, actions), dim=-1)), then)


class GruDynamics(Dynamics):
    """The paper's baseline: a GRU cell from state and actions to the next state."""

    def __init__(self, spec: DynamicsSpec) -> None:
        super().__init__(spec)
        self.enter = nn.Linear(MOVING_WIDTH + CONSTANT_WIDTH, spec.width)
        self.gru = nn.GRU(2 * ACTION_WIDTH, spec.width, batch_first=True)
        self.leave = nn.Linear(spec.width, MOVING_WIDTH)

    def step(self, state: Tensor, constant: Tensor, actions: Tensor) -> Tensor:
        hidden = torch.tanh(self.enter(torch.cat((state, self.of_map(constant)), dim=-1)))
        out, _ = self.gru(actions[:, None], hidden[None])
        predicted: Tensor = self.leave(out[:, 0])
        return state + predicted * self.scale if self.spec.residual else predicted

    def losses(self, state: Tensor, constant: Tensor, actions: Tensor, after: Tensor) -> dict[str, Tensor]:
        error = ((self.step(state, constant, actions) - after) / self.scale)[:, self.learned]
        return {"loss": F.smooth_l1_loss(error, torch.zeros_like(error))}


class QvaeDynamics(Dynamics):
    """The paper's other baseline: an autoencoder whose latent is a row of code words (van den Oord et al. 2017)."""

    def __init__(self, spec: DynamicsSpec) -> None:
        super().__init__(spec)
        self.words = max(spec.latent // CODE_WIDTH, 1)
        self.encoder = _layers(MOVING_WIDTH + CONSTANT_WIDTH, spec.width, self.words * CODE_WIDTH)
        self.latent_step = _layers(self.words * CODE_WIDTH + 2 * ACTION_WIDTH, spec.width, self.words * CODE_WIDTH)
        self.decoder = _layers(self.words * CODE_WIDTH + CONSTANT_WIDTH, spec.width, MOVING_WIDTH)
        self.codes = nn.Parameter(torch.empty(CODES, CODE_WIDTH).uniform_(-1.0, 1.0))

    def quantised(self, latent: Tensor) -> tuple[Tensor, Tensor]:
        """The nearest code words (B, Z), with gradients as if they were the latent, and the loss that ties both."""
        words = latent.reshape(-1, self.words, CODE_WIDTH)
        gaps = ((words[:, :, None] - self.codes) ** 2).sum(dim=-1)  # (B, words, CODES)
        nearest = F.embedding(gaps.argmin(dim=-1), self.codes)
        tie = F.mse_loss(nearest, words.detach()) + COMMITMENT * F.mse_loss(words, nearest.detach())
        return (words + (nearest - words).detach()).flatten(1), tie

    def step(self, state: Tensor, constant: Tensor, actions: Tensor) -> Tensor:
        return self._stepped(state, constant, actions)[0]

    def _stepped(self, state: Tensor, constant: Tensor, actions: Tensor) -> tuple[Tensor, Tensor]:
        of_map = self.of_map(constant)
        now, first = self.quantised(self.encoder(torch.cat((state, of_map), dim=-1)))
        then, second = self.quantised(self.latent_step(torch.cat((now, actions), dim=-1)))
        predicted = self.decoder(torch.cat((then, of_map), dim=-1))
        return (state + predicted * self.scale if self.spec.residual else predicted), first + second

    def losses(self, state: Tensor, constant: Tensor, actions: Tensor, after: Tensor) -> dict[str, Tensor]:
        predicted, tie = self._stepped(state, constant, actions)
        error = ((predicted - after) / self.scale)[:, self.learned]
        prediction = F.smooth_l1_loss(error, torch.zeros_like(error))
        return {"loss": prediction + tie, "prediction": prediction, "codes": tie}


_KINDS: dict[DynamicsKind, type[Dynamics]] = {"vae": VaeDynamics, "gru": GruDynamics, "qvae": QvaeDynamics}


def build_dynamics(spec: DynamicsSpec) -> Dynamics:
    """The network that a spec describes, with fresh weights."""
    return _KINDS[spec.kind](spec)


class Rollout(nn.Module):
    """Several ticks of the learned simulator, as one graph to export.

    With hold levels, a press occurs where the level differs from the predicted hand.
    """

    def __init__(self, dynamics: Dynamics, depth: int, grasp: Grasp) -> None:
        super().__init__()
        self.dynamics = dynamics
        self.depth = depth
        self.levels = grasp == "hold"

    def forward(self, state: Tensor, constant: Tensor, actions: Tensor) -> Tensor:
        """From states (B, 58), constants (B, 146), actions (B, K, 2, 4) with K >= depth to states (B, depth, 58)."""
        states = []
        for tick in range(self.depth):
            motion, grasp = actions[:, tick, :, :3], actions[:, tick, :, 3]
            toggle = (grasp - holding(state)).abs() if self.levels else grasp
            both = torch.cat((motion, toggle[..., None]), dim=-1).flatten(1)
            state = self.dynamics.advance(state, constant, both)
            states.append(state)
        return torch.stack(states, dim=1)


def holding(state: Tensor) -> Tensor:
    """Whether each hand (B, 2) holds something in moving states (B, 58), 1 or 0."""
    empty = torch.stack([state[:, HELD_START + HELD_WIDTH - 1], state[:, HELD_START + 2 * HELD_WIDTH - 1]], dim=1)
    return (empty < 0.5).to(state.dtype)


def tidied(state: Tensor) -> Tensor:
    """Predicted states (B, 58) with hands made one-hot, so that errors do not accumulate."""
    hands = state[:, HELD_START:ITEMS_START].reshape(-1, 2, HELD_WIDTH)
    sharp = (hands >= hands.max(dim=-1, keepdim=True).values).to(state.dtype)
    return torch.cat((state[:, :HELD_START], sharp.flatten(1), state[:, ITEMS_START:]), dim=1)


def carried(before: Tensor, after: Tensor) -> Tensor:
    """The states `after` (B, 58), with items (x, y, cos, sin) moved from `before` by who holds them in both.

    Rotation and shift are linear, so two holders move an item by the mean of their motions.
    """
    hands = (before * after)[:, HELD_START:ITEMS_START].reshape(-1, 2, HELD_WIDTH)[:, :, :-1].transpose(1, 2)
    holders = hands.sum(dim=2, keepdim=True)  # (B, 7, 1)
    motion = (hands @ _motions(before, after)) / holders.clamp(min=1.0)  # (B, 7, 4)
    cos, sin = motion[..., :1] + (1.0 - holders).clamp(min=0.0), motion[..., 1:2]
    items = before[:, ITEMS_START:].reshape(-1, HELD_WIDTH - 1, 4)
    shift = torch.cat((motion[..., 2:], torch.zeros_like(motion[..., 2:])), dim=-1)  # angles do not shift
    placed = cos * items + sin * _turned(items) + shift
    return torch.cat((after[:, :ITEMS_START], placed.flatten(1)), dim=1)


def _motions(before: Tensor, after: Tensor) -> Tensor:
    """The rigid motion of each robot (B, 2, 4): cos and sin of its rotation R and its shift s in p -> R p + s."""
    here, there = (rows[:, :HELD_START].reshape(-1, 2, ROBOT_WIDTH)[..., :4] for rows in (before, after))
    turned = _turned(here)
    facing = there[..., 2:] / (there[..., 2:] ** 2).sum(dim=-1, keepdim=True).sqrt().clamp(min=1e-3)
    cos = (facing * here[..., 2:]).sum(dim=-1, keepdim=True)
    sin = (facing * turned[..., 2:]).sum(dim=-1, keepdim=True)
    shift = there[..., :2] - cos * here[..., :2] - sin * turned[..., :2]
    return torch.cat((cos, sin, shift), dim=-1)


def _turned(vectors: Tensor) -> Tensor:
    """Two vectors x, y, u, v (..., 4), each rotated by 90 degrees: -y, x, -v, u."""
    x, y, u, v = vectors.chunk(4, dim=-1)
    return torch.cat((-y, x, -v, u), dim=-1)
