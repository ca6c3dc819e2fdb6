import copy
import json
import math
import pickle
import subprocess
import sys
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import pytest

pytest.importorskip("pettingzoo", reason="the extra `env` is not installed")

from pettingzoo.test import parallel_api_test, parallel_seed_test

from movingout.maps import MapError, MapSpec, Rect, load_map, map_to_json
from movingout.maps.randomize import Split, randomize
from movingout.world import ActionError, World, WorldError
from movingout.world.action import to_world
from movingout.world.env import REWARDS, MovingOutEnv
from movingout.world.metrics import METRICS
from movingout.world.observation import LAYOUTS, encode_state

STILL = np.array([0.0, 1.0, 0.0, 0.0], np.float32)
ALWAYS = {"score", *(metric.key for metric in METRICS)}


class Comparable(MovingOutEnv):
    """The env with "none" for NaN in its infos, which equals nothing, not even itself."""

    def _infos(self, last: bool = False) -> dict[str, dict[str, Any]]:
        infos = super()._infos(last)
        return {agent: {k: "none" if math.isnan(v) else v for k, v in info.items()} for agent, info in infos.items()}


@pytest.mark.filterwarnings("ignore:reset.. does not know the option 'options'")
@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("split", [None, "train"])
def test_pettingzoos_own_api_test_passes(layout: str, split: Any) -> None:
    parallel_api_test(MovingOutEnv("CornerDecision", layout=layout, split=split, limit_ticks=40), num_cycles=100)


@pytest.mark.parametrize("seed", [-1, 1.5, "3"])
def test_a_seed_that_is_no_number_from_0_on_is_answered_with_a_sentence(seed: Any) -> None:
    with pytest.raises(WorldError, match=f"a seed is a whole number from 0 on, not {seed!r}"):
        MovingOutEnv().reset(seed=seed)


@pytest.mark.parametrize("split", [None, "train", "evaluation"])
def test_pettingzoos_own_seed_test_passes(split: Any) -> None:
    parallel_seed_test(lambda: Comparable("TopBottomPriority", split=split, limit_ticks=20), num_cycles=50)


def test_the_env_is_the_world() -> None:
    env, world = MovingOutEnv("LeftRight"), World(load_map("LeftRight"))
    observations, _ = env.reset(seed=1)
    generator = np.random.default_rng(4)
    for _ in range(20):
        actions = generator.uniform(-1, 1, (2, 4)).astype(np.float32)
        observations, *_ = env.step({"blue": actions[0], "red": actions[1]})
        world.step(to_world(actions))
        for seat, agent in enumerate(("blue", "red")):
            expected = encode_state(world.map, world.state(), seat).astype(np.float32)
            np.testing.assert_array_equal(observations[agent], expected)


def test_seeds_decide_the_variant_and_the_episodes_after_it_differ() -> None:
    def starts(seed: int) -> list[bytes]:
        env = MovingOutEnv("HandOff", split="train")
        first, _ = env.reset(seed=seed)
        second, _ = env.reset()
        return [first["blue"].tobytes(), second["blue"].tobytes()]

    assert starts(3) == starts(3)
    assert len({*starts(3), *starts(4)}) == 4


def test_a_seed_without_a_playable_variant_is_passed_over(monkeypatch: pytest.MonkeyPatch) -> None:
    """Training on a tight map ended at some episode, and a run that was continued came to the same one."""
    calls: list[int] = []

    def tight(designed: MapSpec, seed: int, split: Split) -> MapSpec:
        calls.append(seed)
        if len(calls) % 4:
            raise MapError(f"no playable variant for seed {seed}")
        return randomize(designed, seed, split)

    monkeypatch.setattr("movingout.world.env.randomize", tight)
    env = MovingOutEnv("HandOff", split="train")
    variants = []
    for _ in range(2):
        with pytest.warns(
            UserWarning, match="on HandOff not every seed has a playable train variant; others are tried"
        ):
            env.reset(seed=3)
        variants.append(env.current_map.variant)
    assert len(calls) == 8
    assert len(set(calls)) == 4
    assert variants == [f"challenge2-train-{calls[3]}"] * 2


def test_an_episode_is_truncated_at_its_limit_with_the_metrics() -> None:
    env = MovingOutEnv("HandOff", limit_ticks=3)
    _, infos = env.reset()
    assert set(infos["blue"]) == ALWAYS
    for tick in (1, 2, 3):
        _, _, terminated, truncated, infos = env.step({"blue": STILL, "red": STILL})
        assert terminated == {"blue": False, "red": False}
        assert truncated == dict.fromkeys(("blue", "red"), tick == 3)
        assert set(infos["red"]) == ALWAYS
        assert math.isnan(infos["red"]["tcr"]) == (tick < 3)
    assert env.agents == []
    with pytest.raises(WorldError, match=r"call reset\(\) first"):
        env.step({"blue": STILL, "red": STILL})


def test_an_episode_terminates_when_everything_is_delivered() -> None:

    everywhere = replace(load_map("Simple"), goals=(Rect(-1.2, -1.2, 1.2, 1.2),))
    env = MovingOutEnv(everywhere)
    env.reset()
    _, _, terminated, truncated, infos = env.step({"blue": STILL, "red": STILL})
    assert terminated == {"blue": True, "red": True}
    assert truncated == {"blue": False, "red": False}
    assert infos["blue"]["tcr"] == 1.0
    assert np.isnan(infos["blue"]["ac"])


@pytest.mark.parametrize("reward", REWARDS)
def test_every_reward_pays_both_agents(reward: Any) -> None:
    env = MovingOutEnv("DistancePriority", reward=reward)
    env.reset()
    _, rewards, *_ = env.step({"blue": STILL, "red": STILL})
    assert set(rewards) == {"blue", "red"}
    assert all(value < 0 for value in rewards.values())  # the step cost


def test_a_picture_is_made_when_asked_for() -> None:
    env = MovingOutEnv(render_mode="rgb_array")
    env.reset()
    picture = env.render()
    assert picture is not None
    assert picture.shape == (256, 256, 3)
    with pytest.warns(UserWarning, match='make the environment with render_mode="rgb_array"'):
        assert MovingOutEnv().render() is None


@pytest.mark.parametrize("reward", REWARDS)
@pytest.mark.parametrize("copied", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
def test_a_copy_goes_on_in_the_middle_of_an_episode_as_the_original_does(copied: Any, reward: Any) -> None:
    env = MovingOutEnv("HandOff", layout="aware-v1", reward=reward, split="train", limit_ticks=30)
    env.reset(seed=7)
    generator = np.random.default_rng(3)

    def played(one: MovingOutEnv, actions: Any) -> list[bytes]:
        answers = []
        for pair in actions:
            seen, rewards, _, _, infos = one.step({"blue": pair[0], "red": pair[1]})
            answers.append(pickle.dumps((seen["red"].tobytes(), rewards, infos["red"])))
        return answers

    played(env, generator.uniform(-1, 1, (12, 2, 4)))
    twin = copied(env)
    rest = generator.uniform(-1, 1, (18, 2, 4))
    assert played(twin, rest) == played(env, rest)
    assert twin.reset()[0]["blue"].tobytes() == env.reset()[0]["blue"].tobytes()  # of the next variant


def test_bounds_are_finite_and_hold_under_wild_actions() -> None:
    env = MovingOutEnv("DistancePriority", layout="aware-v1")
    assert np.isfinite(env.state_space.high).all() and np.isfinite(env.state_space.low).all()
    seen, _ = env.reset(seed=1)
    generator = np.random.default_rng(1)
    for _ in range(300):
        assert env.observation_space("blue").contains(seen["blue"])
        assert env.state_space.contains(env.state())
        turn = generator.uniform(-math.pi, math.pi, 2)
        rows = [[generator.choice([-1, 1]), math.cos(a), math.sin(a), generator.uniform() < 0.1] for a in turn]
        seen, *_ = env.step(dict(zip(env.agents, np.array(rows, np.float32), strict=True)))


def test_pictures_are_bytes_in_the_shape_of_a_picture() -> None:
    env = MovingOutEnv("HandOff", layout="image-v1")
    seen, _ = env.reset()
    space = env.observation_space("red")
    assert space.shape == (128, 128, 3) and space.dtype == np.uint8
    assert (space.low.max(), space.high.min()) == (0, 255)
    assert space.contains(seen["red"]) and seen["red"].max() > 200
    flat = encode_state(env.current_map, env.world_state, 1, "image-v1")
    assert np.array_equal(seen["red"].reshape(-1), flat)


def test_the_map_of_an_episode_is_public_and_may_be_chosen_for_it() -> None:
    env = MovingOutEnv("HandOff", split="train")
    env.reset(seed=1)
    assert env.current_map.variant and env.current_map.name == "HandOff"
    env.reset(options={"map": "LeftRight"})
    assert env.current_map.name == "LeftRight"
    env.reset()
    assert env.current_map.name == "HandOff"
    with pytest.warns(UserWarning, match="does not know the option 'mpa'; it knows: map"):
        env.reset(options={"mpa": "LeftRight"})
    with pytest.raises(MapError, match="LeftRigt"):
        env.reset(options={"map": "LeftRigt"})
    with pytest.raises(WorldError, match="a dictionary such as"):
        env.reset(options="LeftRight")  # type: ignore[arg-type]


def test_a_map_file_with_faults_is_warned_about_until_it_is_mended(tmp_path: Path) -> None:
    document = {**map_to_json(load_map("HandOff")), "name": "Mine", "number": 0}
    tiny = [{"x0": -1.2, "y0": 1.2, "x1": -1.19, "y1": 1.19}]
    file = tmp_path / "mine.json"
    file.write_text(json.dumps({**document, "goals": tiny}))
    with pytest.warns(UserWarning, match="mine.json cannot be played as it should: .*goal") as told:
        env = MovingOutEnv(file)
        MovingOutEnv().reset(options={"map": file})
    assert {warning.filename for warning in told} == {__file__} and len(told) == 2
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env.reset(options={"map": file})
        file.write_text(json.dumps(document))
        MovingOutEnv(file).reset(options={"map": str(file)})


def test_a_window_says_what_to_install_and_where_there_is_no_display(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pygame", None)
    with pytest.raises(WorldError, match="pip install pygame"):
        MovingOutEnv(render_mode="human")


def test_a_window_shows_every_state(monkeypatch: pytest.MonkeyPatch) -> None:
    """With a stand-in for pygame, which is not among the dependencies."""
    pygame = mock.MagicMock(error=OSError)
    monkeypatch.setitem(sys.modules, "pygame", pygame)
    env = MovingOutEnv(render_mode="human", limit_ticks=5)
    env.reset()
    env.step({"blue": STILL, "red": STILL})
    assert env.render() is None
    assert pygame.display.flip.call_count == 2
    copy.deepcopy(env).close()
    pygame.display.quit.assert_not_called()
    env.close()
    pygame.display.quit.assert_called_once()
    pygame.display.set_mode.side_effect = OSError("no display")
    with pytest.raises(WorldError, match=r"no window can be opened here \(no display\); render_mode='rgb_array'"):
        env.reset()


def test_a_window_that_another_environment_closed_opens_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """pygame has one for all: after `display.quit()` the picture of the others cannot be drawn on."""
    pygame = mock.MagicMock(error=OSError)
    pygame.display.set_mode.side_effect = lambda size: pygame.display.get_surface()
    monkeypatch.setitem(sys.modules, "pygame", pygame)
    first, second = MovingOutEnv(render_mode="human"), MovingOutEnv(render_mode="human")
    first.reset()
    second.reset()
    first.close()
    pygame.display.get_surface.return_value = mock.MagicMock()  # what set_mode gives from now on
    gone = pygame.display.set_mode.call_count
    second.step({"blue": STILL, "red": STILL})
    second.step({"blue": STILL, "red": STILL})
    assert pygame.display.set_mode.call_count == gone + 1


def test_wrong_arguments_and_actions_are_refused() -> None:
    with pytest.raises(
        WorldError, match="unknown reward 'dense'; known: paper-dense, paper-agent-distance, paper-sparse"
    ):
        MovingOutEnv(reward="dense")  # type: ignore[arg-type]
    for ticks in (0, 2.5, "500"):
        with pytest.raises(WorldError, match=f"a whole number of ticks from 1, not {ticks!r}"):
            MovingOutEnv(limit_ticks=ticks)  # type: ignore[arg-type]
    with pytest.raises(WorldError, match="unknown split 'tran'; did you mean train"):
        MovingOutEnv(split="tran")  # type: ignore[arg-type]
    with pytest.raises(MapError, match="by its name or the path of its file, not by 3"):
        MovingOutEnv(3)  # type: ignore[arg-type]
    with pytest.raises(WorldError, match="unknown layout"):
        MovingOutEnv(layout="v0")
    with pytest.raises(WorldError, match="unknown render mode 'rgb'; known: rgb_array, human, None"):
        MovingOutEnv(render_mode="rgb")  # type: ignore[arg-type]
    with pytest.raises(WorldError, match=r"unknown agent 'green'.*known: blue, red"):
        MovingOutEnv().action_space("green")


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"items": ()}, "HandOff: items: 1 to 7 entries are allowed, not 0"),
        ({"goals": ()}, "HandOff: goals: 1 to 64 entries are allowed, not 0"),
        ({"walls": (Rect(0.0, 0.0, math.nan, 1.0),)}, r"HandOff: walls\[0\]\.x1: a number is needed here, not nan"),
        ({"robots": ()}, "HandOff is not made as MapSpec says: not enough values"),
    ],
)
def test_a_map_object_that_no_file_could_hold_is_refused_as_the_file_is(changes: dict[str, Any], sentence: str) -> None:
    wrong = replace(load_map("HandOff"), **changes)
    with pytest.raises(MapError, match=sentence):
        MovingOutEnv(wrong)
    with pytest.raises(MapError, match=sentence):
        MovingOutEnv().reset(options={"map": wrong})


@pytest.mark.parametrize(
    ("actions", "sentence"),
    [
        ({"blue": STILL, "red": STILL * np.float32(np.nan)}, "must be finite"),
        ({"blue": STILL}, "an action for red is missing"),
        ({"blue": STILL, "red": STILL, "green": STILL}, "there is no agent 'green'; known: blue, red"),
        ({"blue": STILL, "red": STILL[:3]}, "is 4 numbers .*; that of red is array"),
        ({"blue": "ahead", "red": STILL}, "that of blue is 'ahead'"),
        ([STILL, STILL], "a dictionary with those of blue and red, not list"),
    ],
)
def test_wrong_actions_are_refused_with_whose_they_are(actions: Any, sentence: str) -> None:
    env = MovingOutEnv()
    env.reset()
    with pytest.raises(ActionError, match=sentence):
        env.step(actions)


def test_a_tensor_that_requires_grad_is_refused_with_what_to_do() -> None:
    torch = pytest.importorskip("torch")
    env = MovingOutEnv()
    env.reset()
    with pytest.raises(ActionError, match=r"that of blue is tensor\(.*detach\(\)"):
        env.step({"blue": torch.ones(4, requires_grad=True), "red": STILL})
    env.step({"blue": torch.ones(4), "red": STILL})


def test_the_world_package_itself_needs_no_pettingzoo() -> None:

    program = (
        "import sys, world, movingout.world.metrics, movingout.world.raster; sys.exit('pettingzoo' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0


def test_wrappers_find_the_random_numbers_that_a_seed_of_reset_begins() -> None:
    env = MovingOutEnv("HandOff")
    drawn = []
    for _ in range(2):
        env.reset(seed=3)
        drawn.append(env.np_random.integers(1000, size=3).tolist())
    assert drawn[0] == drawn[1]


def test_actions_of_a_layout_in_the_own_frame_are_in_it_too() -> None:
    """They were the arena's: equal observations and actions led elsewhere on a turned map."""
    envs = [MovingOutEnv(name, layout="relative-v1") for name in ("FourCorners", "FourCorners:rot90")]
    seen = [env.reset()[0]["blue"] for env in envs]
    for _ in range(6):
        np.testing.assert_allclose(seen[0], seen[1], atol=1e-5)
        seen = [env.step({"blue": np.array([1.0, 1.0, 0.2, 0.0]), "red": STILL})[0]["blue"] for env in envs]
    assert abs(seen[0][0]) > 0.1, "blue drives"


@pytest.mark.parametrize("layout", ["official-v1", "relative-v1"])
def test_a_heading_of_zeros_keeps_the_robots_own(layout: str) -> None:
    """As in matches (`agents.adapters`), where a policy from elsewhere plays what it learned here."""
    env = MovingOutEnv("FourCorners", layout=layout)
    env.reset()
    before = env.world_state.robot_poses[0].copy()
    for _ in range(10):
        env.step({"blue": np.array([0.5, 0.0, 0.0, 0.0]), "red": STILL})
    after = env.world_state.robot_poses[0]
    assert abs(after[2] - before[2]) < 1e-3 and np.linalg.norm(after[:2] - before[:2]) > 0.1
