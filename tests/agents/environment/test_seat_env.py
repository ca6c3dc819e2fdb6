import copy
import pickle
import subprocess
import sys
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

pytest.importorskip("pettingzoo", reason="the extra `env` is not installed")

import gymnasium
from gymnasium.utils.env_checker import check_env

from movingout.agents.base import ActionChunk, EpisodeInfo
from movingout.agents.base import Observation as AgentObservation
from movingout.agents.environment import ENV_ID
from movingout.agents.environment.seat_env import SeatEnv
from movingout.agents.errors import AgentError
from movingout.maps import Rect, load_map
from movingout.world import ActionError, World
from movingout.world.env import MovingOutEnv
from movingout.world.errors import WorldError
from movingout.world.metrics import METRICS

STILL = np.array([0.0, 1.0, 0.0, 0.0], np.float32)


@pytest.mark.parametrize("seat", ["blue", "red"])
@pytest.mark.parametrize("layout", ["official-v1", "aware-v1"])
def test_gymnasiums_own_checker_passes(seat: str, layout: str) -> None:
    env = gymnasium.make(ENV_ID, map="HandOff", partner=["scripted", "idle"], seat=seat, layout=layout)
    check_env(env.unwrapped, skip_render_check=True)


def test_a_language_model_that_no_step_waits_for_is_warned_about() -> None:
    model = "llm:model=m,url=http://127.0.0.1:9/v1"
    with pytest.warns(UserWarning, match=f"{model} does not wait for its answers") as warned:
        SeatEnv("HandOff", partner=["idle", model])
    assert [Path(one.filename).name for one in warned] == ["test_seat_env.py"]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        SeatEnv("HandOff", partner=f"{model},wait=yes")


def test_it_is_the_world_from_one_seat_with_the_partner_in_the_other() -> None:
    env, both = SeatEnv("LeftRight", partner="idle", seat="red"), MovingOutEnv("LeftRight")
    seen, _ = env.reset(seed=1)
    expected, _ = both.reset()
    generator = np.random.default_rng(2)
    for _ in range(20):
        np.testing.assert_array_equal(seen, expected["red"])
        action = generator.uniform(-1, 1, 4).astype(np.float32)
        seen, reward, *_ = env.step(action)
        expected, rewards, *_ = both.step({"blue": STILL, "red": action})
        assert reward == rewards["red"]


def test_a_map_that_one_of_the_partners_cannot_see_is_refused_before_that_one_is_drawn() -> None:
    goals = tuple(Rect(x, 1.2, x + 0.35, 0.8) for x in (-1.2, -0.75, -0.3, 0.15, 0.6))
    five = replace(load_map("Simple"), name="Five", goals=goals)
    partners = ["family:greedy", "bass@any"]
    with pytest.raises(AgentError, match=r"^bass@any cannot play Five: .* 4 slots for goals; Five has 5"):
        SeatEnv(five, partner=partners)
    env = SeatEnv(partner=partners)
    for seed in range(2):
        with pytest.raises(AgentError, match=r"^bass@any cannot play Five"):
            env.reset(seed=seed, options={"map": five})
    assert SeatEnv(five, partner="family:greedy").reset(seed=0)


def test_a_scripted_partner_does_the_work_and_the_metrics_come_with_the_end() -> None:
    env = SeatEnv("DistancePriority", partner="scripted", seat="red", limit_ticks=120)
    _, info = env.reset(seed=3)
    assert info == {"score": 0.0, "partner": "scripted"}
    truncated = terminated = False
    while not (truncated or terminated):
        _, _, terminated, truncated, info = env.step(STILL)
    assert set(info) == {"score", "partner", *(metric.key for metric in METRICS)}
    assert info["nfd"] > 0.0
    with pytest.raises(Exception, match=r"call reset\(\) first"):
        env.step(STILL)


def test_partners_are_drawn_per_episode_and_a_seed_repeats_them() -> None:
    def drawn(seed: int) -> list[str]:
        env = SeatEnv(partner=["idle", "people:A"], split="train", limit_ticks=5)
        env.reset(seed=seed)
        return [env.reset()[1]["partner"] for _ in range(12)]

    assert drawn(5) == drawn(5)
    assert drawn(5) != drawn(6)
    assert "idle" in drawn(5)
    assert len({name for name in drawn(5) if name.startswith("person:name=A")}) > 1


def test_copies_and_pickles_start_anew_with_the_same_arguments() -> None:
    env = SeatEnv("HandOff", partner="idle", seat="red", layout="map-v1")
    for twin in (copy.deepcopy(env), pickle.loads(pickle.dumps(env))):
        np.testing.assert_array_equal(twin.reset(seed=1)[0], env.reset(seed=1)[0])


@pytest.mark.parametrize(
    "statements",  # the last as importing TorchRL does
    [
        "import gymnasium, movingout",
        "import movingout, gymnasium",
        "import movingout; import importlib.util; importlib.util.find_spec('gymnasium'); import gymnasium",
    ],
)
def test_gymnasium_knows_it_whichever_is_imported_or_looked_for_first(statements: str) -> None:
    code = f"{statements}; print(gymnasium.make({ENV_ID!r}, partner='idle').reset(seed=0)[1]['partner'])"
    assert (
        subprocess.run([sys.executable, "-P", "-c", code], capture_output=True, text=True, check=True).stdout
        == "idle\n"
    )


def test_several_at_once() -> None:
    envs = gymnasium.make_vec(ENV_ID, num_envs=3, vectorization_mode="sync", partner="idle", limit_ticks=2)
    envs.reset(seed=1)
    for _ in range(5):
        seen, *_ = envs.step(envs.action_space.sample())
    assert seen.shape == (3, 121)
    envs.close()


def test_the_picture_is_that_of_the_seat() -> None:
    env = SeatEnv("HandOff", partner="idle", seat="red", render_mode="rgb_array")
    env.reset(seed=1)
    both = MovingOutEnv("HandOff", render_mode="rgb_array")
    both.reset()
    seen, pictures = env.render(), [both.render(seat) for seat in (0, 1)]
    assert seen is not None and pictures[0] is not None and pictures[1] is not None
    np.testing.assert_array_equal(seen, pictures[1])
    assert not np.array_equal(seen, pictures[0])


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"seat": "green"}, "unknown seat 'green'; .*known: blue, red"),
        ({"partner": "scriptd"}, "unknown agent 'scriptd'; did you mean scripted"),
        ({"partner": "greedy:patience=3,patience=4"}, "patience stands twice in its options"),
        ({"partner": []}, "a partner is needed"),
        ({"partner": 3}, 'a partner is the id of an agent, such as "scripted", or a list of ids, not 3'),
        ({"partner": ["idle", None]}, "or a list of ids, not None"),
        ({"partner": "people:Z"}, "unknown population 'Z'; .*known: A, B, C"),
    ],
)
def test_wrong_arguments_are_refused_with_what_is_known(arguments: dict[str, Any], sentence: str) -> None:
    with pytest.raises(AgentError, match=sentence):
        SeatEnv(load_map("HandOff"), **arguments)


RAISING = """
class Late:
    def reset(self, episode):
        if episode.ticks == 7:
            raise KeyError("seven")

    def act(self, observation):
        raise ValueError("no camera")


class Scribbling:
    def reset(self, episode):
        pass

    def act(self, observation):
        observation.state.item_poses[:] = 0
        observation.state.robot_poses[:] = 0
        return [[0, 1, 0, 0]]


class Wrong:
    def reset(self, episode):
        pass

    def act(self, observation):
        return [0, 0]


class Leaving(Scribbling):
    def act(self, observation):
        raise SystemExit(3)


class Interrupting(Scribbling):
    def act(self, observation):
        raise KeyboardInterrupt("mine")


class Pressed(Scribbling):
    def act(self, observation):
        import signal
        signal.raise_signal(signal.SIGINT)


class Rowless(Scribbling):
    execute_rows = None

    def act(self, observation):
        return [[0, 1, 0, 0]] * 2
"""


def test_what_a_partner_raises_names_it_and_its_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "raising_partner.py").write_text(RAISING)
    monkeypatch.syspath_prepend(tmp_path)
    env = SeatEnv(partner="raising_partner:Late")
    env.reset(seed=0)
    told = r"the partner raising_partner:Late raised ValueError in act\(\): no camera \(.*raising_partner.py, line 8\)"
    with pytest.raises(AgentError, match=told) as caught:
        env.step(STILL)
    assert isinstance(caught.value.__cause__, ValueError)
    with pytest.raises(AgentError, match=r"the partner raising_partner:Late raised KeyError in reset\(\): 'seven'"):
        SeatEnv(partner="raising_partner:Late", limit_ticks=7).reset(seed=0)
    env = SeatEnv(partner="raising_partner:Wrong")
    env.reset(seed=0)
    with pytest.raises(AgentError, match=r"the partner raising_partner:Wrong: an action chunk has shape \(H, 4\)"):
        env.step(STILL)
    env = SeatEnv(partner="raising_partner:Leaving")
    env.reset(seed=0)
    with pytest.raises(AgentError, match=r"the partner raising_partner:Leaving raised SystemExit in act\(\): 3"):
        env.step(STILL)
    env = SeatEnv(partner="raising_partner:Interrupting")
    env.reset(seed=0)
    with pytest.raises(AgentError, match=r"raising_partner:Interrupting raised KeyboardInterrupt in act\(\): mine"):
        env.step(STILL)
    env = SeatEnv(partner="raising_partner:Pressed")
    env.reset(seed=0)
    with pytest.raises(KeyboardInterrupt):
        env.step(STILL)
    env = SeatEnv(partner="raising_partner:Rowless")
    env.reset(seed=0)
    with pytest.raises(AgentError, match=r"the partner raising_partner:Rowless: execute_rows is None; it is a whole"):
        env.step(STILL)


def test_what_a_partner_writes_into_its_observation_changes_no_reward(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "scribbling_partner.py").write_text(RAISING)
    monkeypatch.syspath_prepend(tmp_path)
    rewards = []
    for partner in ("idle", "scribbling_partner:Scribbling"):
        env = SeatEnv(partner=partner, reward="paper-dense")
        env.reset(seed=0)
        rewards.append([env.step(STILL)[1] for _ in range(5)])
    assert rewards[0] == rewards[1]


class Watching:
    """An oracle: it plays by the world itself."""

    def reset(self, episode: EpisodeInfo) -> None:
        self._world: World | None = None

    def watch(self, world: World) -> None:
        self._world = world

    def act(self, observation: AgentObservation) -> ActionChunk:
        assert self._world is not None and self._world.tick == observation.tick
        return STILL[None].astype(np.float64)


@pytest.mark.parametrize("wrapped", ["{}", "late:agent={}", "{}:lag=1"])
def test_an_oracle_as_partner_is_given_the_world_of_each_episode(wrapped: str) -> None:
    """It was accepted, and failed after its first tick."""
    env = SeatEnv("HandOff", partner=wrapped.format(f"{__name__}:Watching"))
    for _ in range(2):
        env.reset(seed=1)
        for _ in range(3):
            env.step(STILL)


def test_a_misspelt_option_of_make_is_answered_with_the_right_one() -> None:
    with pytest.raises(TypeError, match="unexpected keyword argument 'partnr'; did you mean partner"):
        gymnasium.make(ENV_ID, partnr="idle")


def test_torchrl_makes_it_although_it_has_no_frame_skip() -> None:
    gym = pytest.importorskip("torchrl.envs.libs.gym")
    assert gym.GymEnv(f"movingout.agents.environment:{ENV_ID}", partner="idle").observation_spec is not None


def test_the_partner_is_known_once_an_episode_has_begun() -> None:
    env = SeatEnv("HandOff", partner="idle")
    with pytest.raises(WorldError, match=r"the partner is drawn when an episode begins; call reset\(\) first"):
        _ = env.partner
    env.reset(seed=0)
    assert env.partner == "idle"
    with pytest.raises(WorldError, match=r"call reset\(\) first"):
        _ = copy.deepcopy(env).partner


class Counting:
    """Counts how often it is asked."""

    asked = 0

    def reset(self, episode: EpisodeInfo) -> None:
        Counting.asked = 0

    def act(self, observation: AgentObservation) -> ActionChunk:
        Counting.asked += 1
        return np.array([[0.0, 1.0, 0.0, 0.0]])


@pytest.mark.parametrize("action", [np.zeros(3), np.full(4, np.nan)])
def test_a_step_that_is_refused_does_not_ask_the_partner(action: npt.NDArray[np.float32]) -> None:
    """It had moved on by a tick when the next step came."""
    env = SeatEnv("HandOff", partner=f"{__name__}:Counting", seat="red")
    env.reset(seed=1)
    with pytest.raises(ActionError):
        env.step(action)
    assert Counting.asked == 0


def test_only_the_learner_acts_in_the_own_frame() -> None:
    own, arena = (SeatEnv("FourCorners", partner="scripted", layout=name) for name in ("relative-v1", "official-v1"))
    for env in (own, arena):
        env.reset(seed=1)
    for _ in range(10):
        angle = arena._env.world_state.robot_poses[0, 2]
        own.step(np.array([1.0, 1.0, 0.0, 0.0]))
        arena.step(np.array([1.0, np.cos(angle), np.sin(angle), 0.0]))
    poses = [env._env.world_state.robot_poses for env in (own, arena)]
    np.testing.assert_allclose(poses[0], poses[1], atol=1e-9)


def test_gymnasium_makes_lists_of_pictures() -> None:
    env = gymnasium.make(ENV_ID, partner="idle", render_mode="rgb_array_list")
    env.reset(seed=0)
    env.step(STILL)
    assert [np.shape(picture) for picture in env.render() or ()] == [(256, 256, 3)] * 2
