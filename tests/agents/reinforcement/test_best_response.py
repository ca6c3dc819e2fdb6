"""Steering a policy by its noise: the imitated policy at first, then what reward asks for, within its leash."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
import torch

from movingout.agents.base import ActionChunk, EpisodeInfo, Observation
from movingout.agents.catalogue import load_agent
from movingout.agents.checkpoint.policy_spec import PolicySpec
from movingout.agents.data.dataset import Singles
from movingout.agents.errors import AgentError, DataError
from movingout.agents.inference.network import PolicyNetwork
from movingout.agents.policies.diffusion_policy import DiffusionPolicy
from movingout.agents.policies.export import export_policy
from movingout.agents.reinforcement.config import ResponseConfig
from movingout.agents.reinforcement.rooms import EpisodeDistribution, PlayRoom, RoomDecision, play_all
from movingout.agents.reinforcement.steered_policy import SteeredPolicy, divergence
from movingout.world import World

SPEC = PolicySpec(
    kind="dp", layout="relative-v1", lags=(2,), obs_horizon=1, horizon=8, execute=2, width=16, depth=1, denoiser="items"
)
MAPS = ("DistancePriority", "generated:awareness:1")
EPISODES = EpisodeDistribution(MAPS, (("idle",), ("scripted",)), 20, load_agent)
CONFIG = ResponseConfig(updates=2, rooms=2, decisions=6, batch=8, passes=1, evaluate_every=1)


def policy() -> SteeredPolicy:
    torch.manual_seed(0)
    return SteeredPolicy(DiffusionPolicy(SPEC).eval())


def test_before_any_training_the_imitated_policy_plays() -> None:
    steered = policy()
    seen, noise = torch.randn(3, 1, SPEC.features), torch.randn(3, 1, 8, 5)
    with torch.inference_mode():
        assert torch.allclose(steered(seen, noise), steered.base(seen, noise), atol=1e-5)
        assert torch.allclose(divergence(*steered.steer(seen[:, 0])), torch.zeros(3), atol=1e-6)
    served = PolicyNetwork(SPEC, export_policy(steered)).run(seen.numpy(), noise.numpy())
    with torch.inference_mode():
        np.testing.assert_allclose(served, steered.base(seen, noise).numpy(), atol=1e-2)


def test_a_policy_that_draws_its_noise_otherwise_cannot_be_steered() -> None:
    other = SPEC.model_copy(update={"process": "ddpm", "sample_steps": 2})
    with pytest.raises(DataError, match="only a policy with --denoiser items and --process flow or ddim"):
        SteeredPolicy(DiffusionPolicy(other))


def test_rooms_play_one_episode_after_another_with_all_partners_on_all_maps() -> None:
    room, maps, seats = PlayRoom(EPISODES, SPEC, 0), set(), set()
    overs = 0
    for _ in range(60):
        maps.add(room._world.map.name)
        seats.add(room._seat)
        result = play_all([room], np.zeros((1, 8, 5), np.float32))
        overs += int(result.over[0])
        assert room.features().shape == (SPEC.features,)
    assert (overs, maps, seats) == (6, set(EPISODES.maps), {0, 1})


def test_a_room_counts_the_progress_that_was_made() -> None:
    room = PlayRoom(
        dataclasses.replace(EPISODES, partners=(("scripted",),), ticks=400, maps=("DistancePriority",)), SPEC, 1
    )
    gains = [room.play(np.zeros((8, 5), np.float32)).gained for _ in range(200)]
    assert 0.1 < sum(gains) < 1.0  # what the expert does alone
    assert min(gains) < max(gains)


class _Driving:
    """A room in which driving ahead is all that counts."""

    def __init__(self, distribution: EpisodeDistribution, spec: PolicySpec, seed: int) -> None:
        self._spec, self._left = spec, 10

    def features(self) -> Singles:
        return np.full(self._spec.features, 0.1, np.float32)

    def play(self, chunk: Singles) -> RoomDecision:
        self._left = self._left - 1 or 10
        over = self._left == 10
        return RoomDecision(0.02 * float(chunk[0, 0]), over, False, self.features() if over else None)


class _Ending(_Driving):
    """A room whose episodes last one decision; in every second one everything is delivered."""

    def features(self) -> Singles:
        return np.full(self._spec.features, 0.01 * self._left, np.float32)

    def play(self, chunk: Singles) -> RoomDecision:
        self._left -= 1
        return RoomDecision(0.0, True, self._left % 2 == 0, np.full(self._spec.features, 0.5, np.float32))


def test_an_episode_that_ran_out_of_time_is_no_end_and_is_judged_by_its_own_last_state(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    pytest.importorskip("torchrl")
    from movingout.agents.reinforcement import best_response

    monkeypatch.setattr(best_response, "PlayRoom", _Ending)
    response = best_response.BestResponse(policy(), EPISODES, dataclasses.replace(CONFIG, rooms=1, decisions=4))
    played, _ = response._play()
    assert torch.equal(played["next", "observation"], torch.full_like(played["observation"], 0.5))
    assert played["observation"][0, :, 0].tolist() == pytest.approx([0.1, 0.09, 0.08, 0.07])
    ends = {name: played["next", name][0, :, 0].tolist() for name in ("done", "terminated", "truncated")}
    assert ends == {"done": [True] * 4, "terminated": [False, True] * 2, "truncated": [True, False] * 2}
    with torch.no_grad():
        response._advantages(played)
        worth = response._learned["critic"](torch.full((1, SPEC.features), 0.5))
    following = played["value_target"][0, :, 0].tolist()
    assert following == pytest.approx([CONFIG.discount * worth.item(), 0.0] * 2, abs=1e-6)


def test_the_last_state_of_an_episode_is_of_its_own_map() -> None:
    room = PlayRoom(dataclasses.replace(EPISODES, ticks=2), SPEC, 0)
    world, seen = room._world, room.features()
    ended = room.play(np.zeros((8, 5), np.float32))
    assert ended.over and room._world is not world
    assert ended.last is not None and not np.array_equal(ended.last, room.features())
    assert np.abs(ended.last - seen).max() < np.abs(room.features() - seen).max()


class Raising:
    """A partner whose code has a fault."""

    def reset(self, episode: EpisodeInfo) -> None:
        """Remember nothing."""

    def act(self, observation: Observation) -> ActionChunk:
        raise RuntimeError("no way home")


class Leaving(Raising):
    """Ends the program instead of answering."""

    def act(self, observation: Observation) -> ActionChunk:
        raise SystemExit("no way home")


@pytest.mark.parametrize(("partner", "raised"), [(Raising, "RuntimeError"), (Leaving, "SystemExit")])
def test_a_partner_that_raises_is_answered_with_a_sentence(partner: type[Raising], raised: str) -> None:
    name = f"{__name__}:{partner.__name__}"
    distribution = dataclasses.replace(EPISODES, maps=("HandOff",), partners=((name,),))
    room = PlayRoom(distribution, SPEC, 0)
    with pytest.raises(AgentError, match=rf"{name} on HandOff, seed \d+: {raised}: no way home \(.*, line"):
        room.play(np.zeros((8, 5), np.float32))


class Silent(Raising):
    """Answers nothing."""

    def act(self, observation: Observation) -> ActionChunk:
        return None  # type: ignore[return-value]


def test_a_partner_that_answers_nothing_is_named() -> None:
    name = f"{__name__}:Silent"
    room = PlayRoom(dataclasses.replace(EPISODES, maps=("HandOff",), partners=((name,),)), SPEC, 0)
    with pytest.raises(AgentError, match=rf"{name} on HandOff, seed \d+: act\(\) returned None"):
        room.play(np.zeros((8, 5), np.float32))


class Watching:
    """An oracle: it plays by the world itself."""

    def reset(self, episode: EpisodeInfo) -> None:
        self._world: World | None = None

    def watch(self, world: World) -> None:
        self._world = world

    def act(self, observation: Observation) -> ActionChunk:
        assert self._world is not None and self._world.tick == observation.tick
        return np.array([[0.0, 1.0, 0.0, 0.0]])


def test_an_oracle_as_partner_is_given_the_world_of_each_episode() -> None:
    episodes = EpisodeDistribution(("DistancePriority",), ((f"{__name__}:Watching",),), 5, load_agent)
    room = PlayRoom(episodes, SPEC, seed=0)
    assert any([room.play(np.zeros((8, 5), np.float32)).over for _ in range(6)])


@pytest.mark.slow
def test_reward_changes_what_is_done_and_the_leash_holds_it_back(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    pytest.importorskip("torchrl")
    from movingout.agents.reinforcement import best_response

    monkeypatch.setattr(best_response, "PlayRoom", _Driving)
    ends = {}
    for leash in (0.0, 10.0):
        config = dataclasses.replace(CONFIG, updates=12, rooms=8, decisions=20, batch=80, rate=5e-3, leash=leash)
        response = best_response.BestResponse(policy(), EPISODES, config)
        told: list[dict[str, float]] = []
        best_response.learn_response(response, tmp_path / str(leash), told.append)
        ends[leash] = (told[-1]["progress per episode"] - told[0]["progress per episode"], told[-1]["divergence"])
    assert ends[0.0][0] > 0.02, "it drives more than it did"
    assert ends[10.0][1] < 0.1 * ends[0.0][1], "on a short leash it stays with the imitated policy"


def test_an_interrupted_response_goes_on(tmp_path: Path) -> None:
    pytest.importorskip("torchrl")
    from movingout.agents.reinforcement.best_response import BestResponse, learn_response

    def stop(told: dict[str, float]) -> None:
        if told["update"] == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):  # saved after the first round alone
        learn_response(BestResponse(policy(), EPISODES, CONFIG), tmp_path, stop)
    again = BestResponse(policy(), EPISODES, CONFIG)
    assert learn_response(again, tmp_path, lambda told: None) == 1
    assert again.round == 2
    assert len((tmp_path / "losses.jsonl").read_text().splitlines()) == 2
    (tmp_path / "resume.safetensors").write_bytes(b"x")
    with pytest.raises(DataError, match="is damaged or of another policy"):
        learn_response(BestResponse(policy(), EPISODES, CONFIG), tmp_path, lambda told: None)
