"""A learned simulator of any observation: two autoencoders and a step between their latent spaces, as in the paper.

    z_t = encode_1(o_t)      z_{t+1} = f(z_t, a_t, a_t^p)      o_{t+n} = decode_2(z_{t+n})

Residual, the second autoencoder is of the change o_{t+n} - o_t: what stays, most of a picture, need not be drawn anew.

It is told neither what the numbers mean nor of a map: observations are those of one agent, with its own action first.
The simulator for Moving Out's state vector (`agents.bass.dynamics`) decodes every tick; this one only the last of n.
"""

from collections.abc import Callable

import torch
from torch import Tensor, nn
from torch.nn import functional as F

from movingout.agents.bass.dynamics import KL_WEIGHT, LATENT_WEIGHT, RECONSTRUCTION_WEIGHT, divergence_of, sampled

MakeEncoder = Callable[[int], nn.Module]
"""A network from observations (B, D) to as many numbers as it is asked for."""
MakeDecoder = Callable[[], nn.Module]
"""A network from a latent (B, Z) to observations (B, D)."""


class LatentAutoEncoder(nn.Module):
    """A variational autoencoder of observations."""

    def __init__(self, encoder: nn.Module, decoder: nn.Module) -> None:
        super().__init__()
        self.encoder, self.decoder = encoder, decoder

    def encode(self, observation: Tensor) -> tuple[Tensor, Tensor]:
        """Mean and log variance (B, Z)."""
        mean, log_variance = self.encoder(observation).chunk(2, dim=-1)
        return mean, log_variance.clamp(-10.0, 4.0)

    def decode(self, latent: Tensor) -> Tensor:
        """(B, D)."""
        out: Tensor = self.decoder(latent)
        return out


class LatentDynamics(nn.Module):
    """Predicts an observation (B, D) after `depth` ticks of both agents' actions (B, depth, A)."""

    def __init__(
        self,
        make_encoder: MakeEncoder,
        make_decoder: MakeDecoder,
        actions: int,
        width: int,
        latent: int,
        *,
        residual: bool,
    ) -> None:
        """`actions`: A, the numbers of both agents' actions in a tick, the own ones first."""
        super().__init__()
        self.residual = residual
        self.now = LatentAutoEncoder(make_encoder(2 * latent), make_decoder())
        self.next = LatentAutoEncoder(make_encoder(2 * latent), make_decoder())
        if residual:
            for parameter in list(self.next.decoder.parameters())[-2:]:  # of the last layer: it begins with no change
                nn.init.zeros_(parameter)
        self.latent_step = nn.Sequential(
            nn.Linear(latent + actions, width), nn.ReLU(), nn.Linear(width, width), nn.ReLU(), nn.Linear(width, latent)
        )

    def forward(self, observation: Tensor, actions: Tensor) -> Tensor:
        latent, _ = self.now.encode(observation)
        predicted = self.next.decode(self._stepped(latent, actions))
        return observation + predicted if self.residual else predicted

    def losses(self, observation: Tensor, actions: Tensor, after: Tensor) -> dict[str, Tensor]:
        """Of observations (B, D), actions (B, depth, A) and the observations (B, D) after them."""
        now_mean, now_variance = self.now.encode(observation)
        target = after - observation if self.residual else after
        then_mean, then_variance = self.next.encode(target)
        now, then = sampled(now_mean, now_variance), sampled(then_mean, then_variance)
        stepped = self._stepped(now, actions)
        prediction = F.mse_loss(self.next.decode(stepped), target)
        reconstruction = F.mse_loss(self.now.decode(now), observation) + F.mse_loss(self.next.decode(then), target)
        latent = F.mse_loss(stepped, then_mean)
        divergence = divergence_of(now_mean, now_variance) + divergence_of(then_mean, then_variance)
        loss = prediction + RECONSTRUCTION_WEIGHT * reconstruction + LATENT_WEIGHT * latent + KL_WEIGHT * divergence
        return {"loss": loss, "prediction": prediction, "reconstruction": reconstruction, "latent": latent}

    def _stepped(self, latent: Tensor, actions: Tensor) -> Tensor:
        for tick in range(actions.shape[1]):
            latent = self.latent_step(torch.cat((latent, actions[:, tick]), dim=-1))
        return latent
