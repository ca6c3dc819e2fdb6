"""MAPPO (Yu et al. 2022): both seats share an actor, and a critic that sees what both see judges them.

From the top: a round is played in all rooms; TorchRL's generalised advantages and clipped objective improve actor and
critic; and so on. What is drawn in a round follows from the seed and the number of the round, and rooms are put back to
the tick at which they were, so that a run that was interrupted arrives at the same weights.
"""

import time
from collections.abc import Callable, Sequence
from contextlib import closing
from pathlib import Path

import numpy as np
import torch
from torch import Tensor, nn

from movingout.agents.checkpoint.policy_spec import PolicySpec
from movingout.agents.errors import DataError
from movingout.agents.reinforcement.joint_play import JointPlay, joint_play
from movingout.agents.reinforcement.learning_room import MODES, Kept, RoomPairing
from movingout.agents.reinforcement.mappo_config import ADAM_EPSILON, CRITIC_LOSS, MappoConfig
from movingout.agents.reinforcement.playing_rooms import LearningRoomSetup, LocalRooms, PlayingRooms
from movingout.agents.reinforcement.ray_rooms import RayRooms
from movingout.agents.reinforcement.resume_file import read_resume, write_resume
from movingout.agents.reinforcement.squashed_normal import SquashedNormal
from movingout.agents.reinforcement.tanh_actor import CentralCritic, TanhActor
from movingout.agents.training.run_folder import RESUME
from movingout.agents.training.run_output import append_losses, cut_losses
from movingout.maps.extras import needs_extra
from movingout.maps.randomize import Split

with needs_extra("rl", "reinforcement learning"):
    from tensordict.nn import TensorDictModule
    from torchrl.modules import ProbabilisticActor, ValueOperator
    from torchrl.objectives import ClipPPOLoss
    from torchrl.objectives.value import GAE

Tell = Callable[[dict[str, float]], None]


class Mappo:
    """Everything that changes while MAPPO learns."""

    def __init__(
        self,
        config: MappoConfig,
        spec: PolicySpec,
        maps: Sequence[str],
        split: Split | None = None,
        pairings: Sequence[RoomPairing] | None = None,
        frozen: Sequence[TanhActor] = (),
        ray: str = "",
    ) -> None:
        """`pairings`: one for each room, self-play without; `frozen`: the partners that they name.

        `ray`: the address of a cluster that plays, else this process does. Raises NoCluster.
        """
        torch.set_num_threads(config.threads)
        self.config, self.frozen, self.round, self.episodes = config, frozen, 0, 0
        self.made = 0  # rounds of this run
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(config.seed)
            self.actor, self.critic = TanhActor(spec), CentralCritic(spec, len(MODES))
        self.pairings = tuple(pairings or [RoomPairing()] * config.envs)
        setups = [
            LearningRoomSetup(tuple(maps), config, split, one, number) for number, one in enumerate(self.pairings)
        ]
        self.rooms: PlayingRooms = RayRooms(ray, setups) if ray else LocalRooms(setups)
        self._learned = nn.ModuleDict({"actor": self.actor, "critic": self.critic})
        value = ValueOperator(self.critic, in_keys=["state"])
        self._advantages = GAE(gamma=config.discount, lmbda=config.trace, value_network=value)
        self._losses = _losses(self.actor, value, config)
        self._optimiser = torch.optim.Adam(self._learned.parameters(), lr=config.rate, eps=ADAM_EPSILON)

    @property
    def frames(self) -> int:
        """Ticks that were played to learn from."""
        return self.round * self.config.room_ticks * self.config.envs

    def learn(self) -> dict[str, float]:
        """One round: play, then improve. Returns what is to be drawn as curves."""
        seed = int(np.random.SeedSequence([self.config.seed, self.round]).generate_state(1)[0])
        generator = torch.Generator().manual_seed(seed)
        noise = torch.randn((len(self.pairings), self.config.room_ticks, 2, 4), generator=generator)
        played = joint_play(self.rooms.play(self.actor, self.frozen, noise), self.pairings)
        chosen, told = self._chosen(played)
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(seed)  # for the loss, which estimates the entropy from samples
            left_out = self._improve(played, chosen, generator)
        if left_out:
            told["updates left out"] = float(left_out)
        self.round += 1
        self.made += 1
        self.episodes += len(played.scores)
        ended = {"score per episode": float(np.mean(played.scores))} if played.scores else {}
        return {**told, "episodes": float(self.episodes), **ended}

    def _chosen(self, played: JointPlay) -> tuple[Tensor, dict[str, float]]:
        """Which rows (2 K, T) are learned from: of the rooms with partners, those with the most compatible one.

        With rewards that count against, as in CoMeDi; where rewards count for, all partners are learned with.
        """
        told = {"reward per tick": played.mean_reward([k for k, one in enumerate(self.pairings) if self._is_own(one)])}
        against = {one.partner for one in self.pairings if one.weight < 0.0}
        if not against:
            return played.learned, told
        rewards = {
            one: played.mean_reward([k for k, pairing in enumerate(self.pairings) if _is_cross(pairing, one)])
            for one in sorted(against)
        }
        most = max(rewards, key=lambda one: rewards[one])
        kept = torch.tensor([one.partner in (-1, most) for one in self.pairings]).repeat_interleave(2)
        return played.learned & kept[:, None], {**told, "with the most compatible": rewards[most]}

    def _is_own(self, pairing: RoomPairing) -> bool:
        return pairing.mode == "self" or all(one.mode == "partner" for one in self.pairings)

    def _improve(self, played: JointPlay, chosen: Tensor, generator: torch.Generator) -> int:
        """Returns how many updates were left out."""
        with torch.no_grad():
            self._advantages(played.rows)
        rows = played.rows[chosen]
        size = 2 * self.config.batch  # both seats
        left_out = 0
        for _ in range(self.config.passes):
            order = torch.randperm(len(rows), generator=generator)
            for start in range(0, len(rows), size):
                left_out += not self._update(rows[order[start : start + size]])
        return left_out

    def _update(self, rows: object) -> bool:
        """Whether the rows were learned from.

        Where the actor has become nearly certain, the ratio of an action's densities can be infinite: such gradients
        would make all weights NaN.
        """
        losses = self._losses(rows)
        loss = losses["loss_objective"] + losses["loss_critic"] + losses.get("loss_entropy", 0.0)
        self._optimiser.zero_grad(set_to_none=True)
        loss.backward()
        networks = (self.actor, self.critic)
        norms = [nn.utils.clip_grad_norm_(one.parameters(), self.config.clip or 1e9) for one in networks]
        if not torch.stack(norms).isfinite().all():
            return False
        self._optimiser.step()
        return True

    def save(self, path: Path) -> None:
        """Everything needed to continue, rooms included, as plain tensors."""
        others = {"round": torch.tensor(self.round), "episodes": torch.tensor(self.episodes)}
        for number, kept in enumerate(self.rooms.kept()):
            others[f"room.{number}.episode"] = torch.tensor(kept.episode)
            others[f"room.{number}.actions"] = torch.from_numpy(kept.actions)
        write_resume(path, self._learned, self._optimiser, others)

    def resume(self, path: Path) -> None:
        """Load what `save` wrote, if it is there. Raises DataError when it is damaged or of another agent."""
        if not path.exists():
            return
        others = read_resume(path, self._learned, self._optimiser)
        try:
            self.round, self.episodes = int(others["round"]), int(others["episodes"])
            numbered = [f"room.{number}" for number in range(len(self.pairings))]
            kept = [Kept(int(others[f"{one}.episode"]), others[f"{one}.actions"].numpy()) for one in numbered]
        except KeyError as error:
            raise DataError(f"{path} was begun with fewer environments; choose another --id") from error
        self.rooms.put_back(kept)


def learn_mappo(mappo: Mappo, folder: Path, tell: Tell) -> None:
    """Learn to the end, continuing from the folder's resume file if there is one."""
    folder.mkdir(parents=True, exist_ok=True)
    mappo.resume(folder / RESUME)
    cut_losses(folder, "round", mappo.round)
    begun, rounds = time.monotonic(), mappo.config.rounds
    with closing(mappo.rooms):
        while mappo.round < rounds:
            values = mappo.learn()
            told = {"frames": float(mappo.frames), **values}
            append_losses(folder, {"round": mappo.round, **told, "seconds": round(time.monotonic() - begun, 1)})
            tell(told)
            if mappo.round % mappo.config.evaluate_every == 0 or mappo.round >= rounds:
                mappo.save(folder / RESUME)


def _losses(actor: TanhActor, value: ValueOperator, config: MappoConfig) -> ClipPPOLoss:
    distribution = ProbabilisticActor(
        TensorDictModule(_Moments(actor), in_keys=["observation"], out_keys=["loc", "scale"]),
        in_keys=["loc", "scale"],
        distribution_class=SquashedNormal,
        return_log_prob=True,
    )
    return ClipPPOLoss(
        distribution, value, clip_epsilon=config.clip_ratio, entropy_bonus=config.entropy > 0.0,
        entropy_coeff=config.entropy or 0.01, critic_coeff=config.critic_weight, loss_critic_type=CRITIC_LOSS,
        normalize_advantage=config.normalise,
    )  # fmt: skip


def _is_cross(pairing: RoomPairing, partner: int) -> bool:
    return pairing.mode == "partner" and pairing.partner == partner


class _Moments(nn.Module):
    """The actor as what TorchRL asks for: location and scale of observations."""

    def __init__(self, actor: TanhActor) -> None:
        super().__init__()
        self.actor = actor

    def forward(self, observation: Tensor) -> tuple[Tensor, Tensor]:
        return self.actor.moments(observation)
