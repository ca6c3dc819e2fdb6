"""MAPPO and CoMeDi: equal seeds give equal weights, also after an interruption; what they learn takes a seat."""

import json
from pathlib import Path

import numpy as np
import pytest
import torch
from torch import Tensor

pytest.importorskip("torchrl")

from movingout.agents.errors import DataError
from movingout.agents.inference.network import PolicyNetwork
from movingout.agents.policies.export import export_policy
from movingout.agents.reinforcement.comedi import answering, differing, learn_comedi
from movingout.agents.reinforcement.joint_play import JointPlay, joint_play
from movingout.agents.reinforcement.learning_room import LearningRoom, RoomPairing
from movingout.agents.reinforcement.mappo import Mappo, learn_mappo
from movingout.agents.reinforcement.mappo_config import ComediConfig, MappoConfig
from movingout.agents.reinforcement.playing_rooms import LocalRooms
from movingout.agents.reinforcement.tanh_actor import TanhActor
from movingout.agents.training.run_folder import RESUME

TINY = {"frames": 36, "frames_per_batch": 18, "passes": 2, "batch": 8, "ticks": 7, "width": 8, "depth": 1}
CONFIG = MappoConfig(envs=3, evaluate_every=1, **TINY)  # type: ignore[arg-type]
COMEDI = ComediConfig(envs=3, members=2, entropy=0.01, **TINY)  # type: ignore[arg-type]
MAPS = "HandOff", "DistancePriority"


def mappo(config: MappoConfig = CONFIG, pairings: list[RoomPairing] | None = None, **others: object) -> Mappo:
    return Mappo(config, config.spec("mappo"), MAPS, None, pairings, **others)  # type: ignore[arg-type]


def a_round(one: Mappo, ticks: int = 7) -> JointPlay:
    noise = torch.randn((len(one.pairings), ticks, 2, 4), generator=torch.Generator().manual_seed(0))
    return joint_play(one.rooms.play(one.actor, one.frozen, noise), one.pairings)


def weights(one: Mappo) -> list[Tensor]:
    return [tensor.clone() for tensor in (*one.actor.state_dict().values(), *one.critic.state_dict().values())]


def equal(one: list[Tensor], other: list[Tensor]) -> bool:
    return all(torch.equal(a, b) for a, b in zip(one, other, strict=True))


def test_equal_seeds_give_equal_weights_also_after_an_interruption(tmp_path: Path) -> None:
    torch.manual_seed(1)
    whole = mappo()
    told: list[dict[str, float]] = []
    learn_mappo(whole, tmp_path / "whole", told.append)
    assert [one["frames"] for one in told] == [18, 36] and told[-1]["episodes"] > 0
    begun = mappo()
    begun.learn()
    begun.save(tmp_path / "begun.safetensors")
    torch.manual_seed(2)
    continued = mappo()
    assert not equal(weights(continued), weights(begun)), "a round has changed them"
    continued.resume(tmp_path / "begun.safetensors")
    assert continued.rooms.kept()[0].actions.shape == begun.rooms.kept()[0].actions.shape != (0, 2, 4)
    continued.learn()
    assert equal(weights(continued), weights(whole))
    again = mappo()
    learn_mappo(again, tmp_path / "whole", told.append)
    assert len(told) == 2 and equal(weights(again), weights(whole)), "it was there already"


def test_rounds_that_are_played_again_after_a_kill_are_in_the_curve_once(tmp_path: Path) -> None:
    def stop(told: dict[str, float]) -> None:
        if told["frames"] == 54:
            raise KeyboardInterrupt

    config = MappoConfig(envs=3, evaluate_every=2, **{**TINY, "frames": 72})  # type: ignore[arg-type]
    with pytest.raises(KeyboardInterrupt):
        learn_mappo(mappo(config), tmp_path, stop)
    learn_mappo(mappo(config), tmp_path, lambda told: None)
    curve = [json.loads(line) for line in (tmp_path / "losses.jsonl").read_text().splitlines()]
    assert [(line["round"], line["frames"]) for line in curve] == [(1, 18), (2, 36), (3, 54), (4, 72)]


def test_another_seed_gives_other_weights() -> None:
    other = mappo(MappoConfig(envs=3, seed=1, **TINY))  # type: ignore[arg-type]
    assert not equal(weights(mappo()), weights(other))


def test_what_plays_is_what_has_learned() -> None:
    actor = mappo().actor
    seen, noise = torch.rand(3, 1, actor.spec.features), torch.randn(3, 1, 1, 5)
    with torch.inference_mode():
        chunk = actor(seen, noise)
        loc, scale = actor.moments(seen[:, 0])
        action = actor.squashed(loc + scale * noise[:, 0, 0, :4])
    assert torch.allclose(chunk[:, 0, :3], action[:, :3]) and chunk.shape == (3, 1, 5)
    assert torch.equal(chunk[:, 0, 4] > chunk[:, 0, 3], action[:, 3] > 0.5)
    served = PolicyNetwork(actor.spec, export_policy(actor)).run(seen.numpy(), noise.numpy())
    np.testing.assert_allclose(served, chunk.numpy(), atol=1e-2)


@pytest.mark.slow
def test_reward_changes_what_is_done(monkeypatch: pytest.MonkeyPatch) -> None:
    """With a reward for driving ahead, more distance is asked for after some rounds."""

    def paid(room: LearningRoom, actions: np.ndarray[tuple[int, ...], np.dtype[np.float32]]) -> object:
        tick = step(room, actions)
        return tick._replace(rewards=actions[:, 0].copy())

    step = LearningRoom.step
    monkeypatch.setattr(LearningRoom, "step", paid)
    one = mappo(MappoConfig(envs=3, **{**TINY, "frames_per_batch": 90, "ticks": 30}, rate=5e-3))  # type: ignore[arg-type]
    told = [one.learn()["reward per tick"] for _ in range(8)]
    assert told[-1] > told[0] + 0.2


def test_a_frozen_partner_acts_in_its_seat_and_is_not_learned_from() -> None:
    frozen = mappo().actor.requires_grad_(False)
    one = mappo(
        pairings=[RoomPairing("partner", -0.5, 0), RoomPairing("mixed", 0.5, 0), RoomPairing()], frozen=(frozen,)
    )
    assert isinstance(one.rooms, LocalRooms)
    cross, mixed, own = one.rooms.rooms
    assert (cross.partner_seat, own.partner_seat) == (1, -1)
    assert (cross.learned, own.learned) == ((True, False), (True, True))
    learned = []
    for _ in range(7):
        learned.append(mixed.learned)
        assert (mixed.partner_seat < 0) == all(mixed.learned)
        mixed.step(np.zeros((2, 4), np.float32))
    assert learned == sorted(learned) and learned[0] == (False, False) and learned[-1] == (True, True)
    played = a_round(one)
    assert played.learned[0].all() and not played.learned[1].any(), "blue learns, red is the partner"
    assert torch.allclose(played.rows["next", "reward"][0, :, 0], -0.5 * played.rewards[0])


def test_only_the_most_compatible_partner_counts_against() -> None:
    frozen = (mappo().actor, mappo().actor)
    pairings = [RoomPairing(), RoomPairing("partner", -0.5, 0), RoomPairing("partner", -0.5, 1)]
    one = mappo(pairings=pairings, frozen=frozen)
    played = a_round(one)
    played.rewards[2:4], played.rewards[4:6] = 0.1, 0.2
    chosen, told = one._chosen(played)
    assert chosen[:2].all() and not chosen[2:4].any() and chosen[4:6].any()
    assert told["with the most compatible"] == pytest.approx(0.2)


def test_conventions_are_learned_one_after_another_and_then_answered(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    told: list[str] = []
    run = COMEDI, COMEDI.spec("comedi"), MAPS, None
    whole = learn_comedi(*run, tmp_path / "whole", lambda name, _: told.append(name))
    assert list(dict.fromkeys(told)) == ["convention-1", "convention-2", "answer"]
    assert not equal(weights(whole[0]), weights(whole[1]))

    class Stopped(Exception):
        pass

    def stopping(name: str, _: object) -> None:
        if name == "convention-2":
            raise Stopped

    with pytest.raises(Stopped):
        learn_comedi(*run, tmp_path / "stopped", stopping)
    kept = (tmp_path / "stopped" / "convention-1" / RESUME).read_bytes()
    again = learn_comedi(*run, tmp_path / "stopped", lambda *_: None)
    assert (tmp_path / "stopped" / "convention-1" / RESUME).read_bytes() == kept
    assert equal(weights(again[-1]), weights(whole[-1]))


def test_rooms_are_shared_among_earlier_conventions() -> None:
    config = ComediConfig(envs=6, members=3)
    assert differing(config, 0) == [RoomPairing()] * 6
    assert [(one.mode, one.partner) for one in differing(config, 2)] == [
        ("self", -1), ("partner", 0), ("mixed", 0), ("self", -1), ("partner", 1), ("mixed", 1),
    ]  # fmt: skip
    assert [one.partner for one in answering(config)] == [0, 1, 2, 0, 1, 2]
    with pytest.raises(DataError, match="--envs 5: 3 members need 6 environments"):
        ComediConfig(envs=5, members=3).check()


def test_a_damaged_resume_file_is_named(tmp_path: Path) -> None:
    one = mappo()
    (tmp_path / RESUME).write_bytes(b"no tensors")
    with pytest.raises(DataError, match="is damaged or of another policy"):
        one.resume(tmp_path / RESUME)
    one.save(tmp_path / RESUME)
    with pytest.raises(DataError, match="fewer environments"):
        mappo(MappoConfig(envs=4, **TINY)).resume(tmp_path / RESUME)  # type: ignore[arg-type]


def test_actors_are_the_size_that_the_paper_says() -> None:
    actor = TanhActor(MappoConfig().spec("mappo"))
    assert [tuple(one.shape) for one in actor.head.parameters()][::2] == [(256, 121), (256, 256), (8, 256)]


def test_an_update_whose_gradients_are_infinite_is_left_out_and_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    one, before = mappo(), weights(mappo())
    losses = one._losses

    def infinite(rows: object) -> object:
        found = losses(rows)
        found["loss_objective"] = found["loss_objective"] * float("inf")
        return found

    monkeypatch.setattr(one, "_losses", infinite)
    told = one.learn()
    assert told["updates left out"] > 0 and equal(weights(one), before)
    monkeypatch.setattr(one, "_losses", losses)
    assert "updates left out" not in one.learn() and not equal(weights(one), before)
