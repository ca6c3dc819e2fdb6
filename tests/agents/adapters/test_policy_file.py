"""A policy's file in a seat: what it takes, and what is said about a file that cannot play."""

import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import onnx
import pytest
import torch
from onnx import TensorProto, helper, numpy_helper

from movingout.agents.adapters.chunk_player import VectorPlayer
from movingout.agents.adapters.layout_choice import LAYOUT_KEY
from movingout.agents.adapters.option_files import file_fingerprint
from movingout.agents.base import Agent, EpisodeInfo
from movingout.agents.catalogue import agent_card, load_agent, open_to_all
from movingout.agents.checkpoint.checkpoint import MODELS_VARIABLE, SHIPPED
from movingout.agents.checkpoint.onnx_interface import NETWORK_KEY
from movingout.agents.errors import AgentError
from movingout.agents.observation.seat_observation import observe, start_state
from movingout.agents.recording_metadata import seat_info
from movingout.maps import load_map
from movingout.server.cli import main
from movingout.world.observation import encode_state

MAP = load_map("HandOff")
ROW = [0.5, 1.0, 0.0, 0.0]


def onnx_file(path: Path, features: int, rows: int = 1, history: int = 0, batch: str | int = "batch") -> Path:
    """A linear policy that answers `rows` actions, ROW plus a hundredth of the first number that it sees."""
    seen = [batch, *([history] if history else []), features]
    weights = np.zeros((features * max(history, 1), 4 * rows), dtype=np.float32)
    weights[0, 0] = 0.01
    nodes = [
        helper.make_node("Flatten", ["obs"], ["flat"]),
        helper.make_node("Gemm", ["flat", "w", "b"], ["numbers"]),
        helper.make_node("Reshape", ["numbers", "shape"], ["actions"]),
    ]
    shape = [-1, 4] if rows == 1 else [-1, rows, 4]
    constants = [
        numpy_helper.from_array(weights, "w"),
        numpy_helper.from_array(np.array(ROW * rows, dtype=np.float32), "b"),
        numpy_helper.from_array(np.array(shape, dtype=np.int64), "shape"),
    ]
    graph = helper.make_graph(
        nodes,
        "policy",
        [helper.make_tensor_value_info("obs", TensorProto.FLOAT, seen)],
        [helper.make_tensor_value_info("actions", TensorProto.FLOAT, None)],
        constants,
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=9)
    onnx.save(model, str(path))
    return path


def exported(path: Path, version: int, seen: list[int], nodes: list[onnx.NodeProto], **constants: Any) -> Path:
    """A policy of `nodes`, from `obs` to `features` (1, 121), which answers ROW."""
    arrays = {"w": np.zeros((121, 4), np.float32), "b": np.array(ROW, np.float32), **constants}
    graph = helper.make_graph(
        [*nodes, helper.make_node("Gemm", ["features", "w", "b"], ["actions"])],
        "policy",
        [helper.make_tensor_value_info("obs", TensorProto.FLOAT, seen)],
        [helper.make_tensor_value_info("actions", TensorProto.FLOAT, [1, 4])],
        [numpy_helper.from_array(np.asarray(array), name) for name, array in arrays.items()],
    )
    onnx.save(helper.make_model(graph, opset_imports=[helper.make_opsetid("", version)], ir_version=10), str(path))
    return path


def scripted(path: Path, module: torch.nn.Module, layout: str = "") -> Path:
    with pytest.warns(DeprecationWarning):
        torch.jit.save(torch.jit.script(module), str(path), _extra_files={LAYOUT_KEY: layout} if layout else None)
    return path


def first_rows(agent: Agent) -> list[list[float]]:
    agent.reset(EpisodeInfo(MAP, 0, seed=0, ticks=500))
    rows: list[list[float]] = np.round(agent.act(observe(MAP, start_state(MAP), 0)), 4).tolist()
    return rows


@pytest.mark.parametrize(("layout", "size"), [("official-v1", 121), ("map-v1", 169), ("aware-v1", 278)])
def test_an_onnx_file_plays_in_the_layout_that_its_size_says(tmp_path: Path, layout: str, size: int) -> None:
    agent = load_agent(f"onnx:path={onnx_file(tmp_path / 'p.onnx', size)}")
    own_x = float(encode_state(MAP, start_state(MAP), 0, layout)[0])
    assert first_rows(agent) == [[round(0.5 + 0.01 * own_x, 4), 1.0, 0.0, 0.0]]


def test_a_chunk_is_played_in_turn_and_decided_anew_when_it_is_over(tmp_path: Path) -> None:
    file = onnx_file(tmp_path / "p.onnx", 121, rows=3, history=2, batch=1)
    for execute, lengths in ((0, [3, 2, 1, 3]), (2, [3, 2, 3, 2])):
        agent = load_agent(f"onnx:path={file},execute={execute}")
        agent.reset(EpisodeInfo(MAP, 0, seed=0, ticks=500))
        state = start_state(MAP)
        assert [len(agent.act(observe(MAP, state, 0, tick))) for tick in range(4)] == lengths


def test_an_onnx_file_may_say_its_layout_and_is_held_to_it(tmp_path: Path) -> None:
    file = onnx_file(tmp_path / "p.onnx", 169)
    model = onnx.load(str(file))
    helper.set_model_props(model, {LAYOUT_KEY: "official-v1"})
    onnx.save(model, str(file))
    with pytest.raises(AgentError, match="takes 169 numbers, official-v1 has 121"):
        load_agent(f"onnx:path={file}")
    assert first_rows(load_agent(f"onnx:path={file},layout=map-v1"))


def test_operators_that_exporters_of_torch_write_are_taken(tmp_path: Path) -> None:
    node = helper.make_node
    nan_to_num = [node("IsNaN", ["obs"], ["nan"]), node("Where", ["nan", "zero", "obs"], ["features"])]
    one_hot = [
        node("ArgMax", ["obs"], ["best"], axis=1, keepdims=0),
        node("OneHot", ["best", "depth", "values"], ["features"]),
    ]
    attention = [
        node("Attention", ["obs", "obs", "obs"], ["after"], q_num_heads=1, kv_num_heads=1),
        node("Flatten", ["after"], ["features"]),
    ]
    values = {"depth": np.int64(121), "values": np.array([0, 1], np.float32)}
    for file in (
        exported(tmp_path / "atan2.onnx", 18, [1, 121], nan_to_num, zero=np.float32(0)),
        exported(tmp_path / "one_hot.onnx", 18, [1, 121], one_hot, **values),
        exported(tmp_path / "attention.onnx", 23, [1, 1, 121], attention),
    ):
        assert first_rows(load_agent(f"onnx:path={file}")) == [ROW]


def test_a_file_named_without_its_kind_is_answered_with_its_id(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name, right in (("p.onnx", "onnx"), ("p.pt", "torchscript"), ("p.zip", "sb3")):
        (tmp_path / name).touch()
        for path in (name, f"./{name}"):
            with pytest.raises(AgentError, match=f"name the file with its kind: {right}:path={re.escape(path)}$"):
                load_agent(path)
    with pytest.raises(AgentError, match=r"package\.module:Factory for your own"):
        load_agent("nowhere.onnx")


def test_a_policy_is_tried_with_an_observation_that_occurs(tmp_path: Path) -> None:
    """It was tried with zeros: one that divides by their length was refused, and one that fails anywhere else taken."""
    node = helper.make_node
    length = [node("ReduceL2", ["obs"], ["length"], axes=[1]), node("Div", ["obs", "length"], ["features"])]
    root = [node("Neg", ["obs"], ["less"]), node("Abs", ["obs"], ["more"])]
    root += [node("Sub", ["less", "more"], ["negative"]), node("Sqrt", ["negative"], ["features"])]
    assert first_rows(load_agent(f"onnx:path={exported(tmp_path / 'norm.onnx', 17, [1, 121], length)}")) == [ROW]
    with pytest.raises(AgentError, match="answers the first observation of HandOff with numbers that are not finite"):
        load_agent(f"onnx:path={exported(tmp_path / 'root.onnx', 17, [1, 121], root)}")


class Linear(torch.nn.Module):
    def __init__(self, features: int, answers: int = 4) -> None:
        super().__init__()
        self.layer = torch.nn.Linear(features, answers)
        torch.nn.init.zeros_(self.layer.weight)
        with torch.no_grad():
            self.layer.bias.copy_(torch.tensor((ROW + ROW)[:answers]))

    def forward(self, seen: torch.Tensor) -> torch.Tensor:
        answer: torch.Tensor = self.layer(seen)
        return answer


def test_a_torchscript_file_plays_in_the_layout_that_it_or_the_user_names(tmp_path: Path) -> None:
    plain = scripted(tmp_path / "plain.pt", Linear(169))
    saying = scripted(tmp_path / "saying.pt", Linear(169), "map-v1")
    for agent_id in (f"torchscript:path={plain},layout=map-v1", f"torchscript:path={saying}"):
        assert first_rows(load_agent(agent_id)) == [ROW]
    with pytest.raises(AgentError, match=r"does not say its layout; add layout=NAME: official-v1 \(121 numbers\)"):
        load_agent(f"torchscript:path={plain}")
    with pytest.raises(AgentError, match=r"does not take official-v1 \(121 numbers\): .*121"):
        load_agent(f"torchscript:path={plain},layout=official-v1")


@pytest.mark.parametrize("history", [0, 2])
def test_a_file_with_the_batch_of_its_training_says_so(tmp_path: Path, history: int) -> None:
    """It said "Please fix either the inputs/outputs or the model" and nothing else."""
    file = onnx_file(tmp_path / "p.onnx", 121, history=history, batch=8)
    with pytest.raises(AgentError, match=r"the input obs has shape \[8, .*121\], with a batch of 8: .* a batch of 1"):
        load_agent(f"onnx:path={file}")


class Refusing(VectorPlayer):
    said = ""

    def _infer(self, seen: Any) -> Any:
        raise RuntimeError(self.said)


def test_all_that_a_library_says_is_given_and_of_a_long_traceback_its_end() -> None:
    agent = Refusing("official-v1", 1, 0, "toggle")
    for said, told in (("Got: 2\n index: 0\n Fix it.\n", "Got: 2 index: 0 Fix it."), ("x\n" * 200 + "end", "end")):
        agent.said = said
        with pytest.raises(AgentError, match=rf"does not take official-v1 \(121 numbers\): {told}$"):
            agent._try(agent._infer)


class Aimless(torch.nn.Module):
    def forward(self, seen: torch.Tensor) -> torch.Tensor:
        return torch.zeros(seen.shape[0], 4) + torch.tensor([0.0, 0.0, 0.0, 1.0])


def test_no_direction_keeps_the_heading_and_hold_presses_once(tmp_path: Path) -> None:
    file = scripted(tmp_path / "p.pt", Aimless(), "official-v1")
    angle = MAP.robots[0].angle
    agent = load_agent(f"torchscript:path={file},grasp=hold")
    assert first_rows(agent) == [[0.0, round(float(np.cos(angle)), 4), round(float(np.sin(angle)), 4), 1.0]]
    state = start_state(MAP)
    state.held[0] = 0
    assert agent.act(observe(MAP, state, 0, 1))[0, 3] == 0.0


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ("path=nowhere.onnx", "there is no nowhere.onnx; onnx:path= names an .onnx file"),
        ("path=.", ". is a folder; onnx:path= names an .onnx file"),
        ("", "missing a required argument: 'path'; options: path, layout, execute, grasp"),
        ("path=wide.onnx", "takes 50 numbers, which is no layout: official-v1 (121 numbers), map-v1"),
        ("path=good.onnx,layout=map-v2", "unknown layout 'map-v2'; known: official-v1"),
        ("path=good.onnx,layout=map-v1", "the policy takes 121 numbers, map-v1 has 169"),
        ("path=good.onnx,execute=-1", "execute is a whole number of ticks"),
        ("path=good.onnx,grasp=grab", "unknown grasp 'grab'; known: toggle, hold"),
        ("path=long.onnx", "answers with shape (1, 65, 4); an action is 4 numbers"),
        ("path=text.onnx", "text.onnx: the ONNX file is damaged"),
        ("path=foreign.onnx", "uses operators of 'com.evil'"),
        (
            "path=two.onnx",
            "takes noise [1, 4] beside the observation; a recurrent graph gives such a memory back",
        ),
    ],
)
def test_a_file_that_cannot_play_is_answered_with_a_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, options: str, sentence: str
) -> None:
    monkeypatch.chdir(tmp_path)
    onnx_file(tmp_path / "good.onnx", 121)
    onnx_file(tmp_path / "wide.onnx", 50)
    onnx_file(tmp_path / "long.onnx", 121, rows=65)
    (tmp_path / "text.onnx").write_text("hello")
    foreign = onnx.load(str(tmp_path / "good.onnx"))
    foreign.graph.node[0].domain = "com.evil"
    onnx.save(foreign, str(tmp_path / "foreign.onnx"))
    two = onnx.load(str(tmp_path / "good.onnx"))
    two.graph.input.append(helper.make_tensor_value_info("noise", TensorProto.FLOAT, [1, 4]))
    onnx.save(two, str(tmp_path / "two.onnx"))
    with pytest.raises(AgentError) as raised:
        load_agent(f"onnx:{options}")
    assert sentence in str(raised.value)


@pytest.mark.parametrize(("kind", "package"), [("sb3", "stable-baselines3"), ("lerobot", "lerobot")])
def test_a_missing_package_is_named_with_its_command(kind: str, package: str) -> None:
    with pytest.raises(AgentError, match=f"needs the package {package}; install it with: pip install {package}"):
        load_agent(f"{kind}:path=x")


def test_torchscript_that_is_none_and_answers_that_are_no_actions(tmp_path: Path) -> None:
    (tmp_path / "text.pt").write_text("hello")
    with pytest.raises(AgentError, match="is not a TorchScript file; write it with"):
        load_agent(f"torchscript:path={tmp_path / 'text.pt'}")
    file = scripted(tmp_path / "p.pt", Linear(121, 3), "official-v1")
    with pytest.raises(AgentError, match=r"answers with shape \(1, 3\); an action is 4 numbers"):
        load_agent(f"torchscript:path={file}")


def test_a_file_is_no_partner_that_anybody_may_ask_for(tmp_path: Path) -> None:
    file = onnx_file(tmp_path / "p.onnx", 121)
    assert not any(open_to_all(f"{kind}:path={file}") for kind in ("onnx", "torchscript", "sb3", "lerobot"))
    assert not any(open_to_all(agent_id) for agent_id in ("onnx", "os:system", "ghost:x.mcap#red"))
    assert all(open_to_all(agent_id) for agent_id in ("scripted", "scripted:seed=3", "bass@all", "dp@all:lag=1"))


def test_a_recording_names_the_file_by_its_content(tmp_path: Path) -> None:
    agent_id = f"onnx:path={onnx_file(tmp_path / 'p.onnx', 121)}"
    card = agent_card(agent_id)
    assert (card.id, card.name, card.kind) == (agent_id, "p.onnx", "policy")
    assert len(seat_info(agent_id).checkpoint_sha256) == 64
    with pytest.raises(AgentError, match="there is no nowhere"):
        agent_card("lerobot:path=nowhere")
    before = file_fingerprint(f"lerobot:path={tmp_path}")
    onnx_file(tmp_path / "p.onnx", 121, rows=2)
    assert seat_info(agent_id).checkpoint_sha256 != file_fingerprint(f"lerobot:path={tmp_path}") != before
    assert not file_fingerprint("onnx:path=nowhere") and not file_fingerprint("scripted:path=x")


def test_a_file_plays_a_match_and_keeps_the_contract(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    agent_id = f"onnx:path={onnx_file(tmp_path / 'p.onnx', 121, rows=3)}"
    assert main(["agents", "check", agent_id, "--ticks", "20", "--map", "HandOff"]) == 0
    assert main(["match", "--red", agent_id, "--blue", "idle", "--map", "HandOff", "--ticks", "10"]) == 0
    assert "p.onnx" in capsys.readouterr().out


def test_the_network_of_a_checkpoint_is_answered_with_the_agents_id(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv(MODELS_VARIABLE, raising=False)
    shipped = SHIPPED / "dp-any" / "policy.onnx"
    for wrong in (f"onnx:path={shipped}", str(shipped), f"onnx:path={shipped.parent}", str(shipped.parent)):
        with pytest.raises(AgentError, match=r"of the trained agent dp@any, which is named by its id: dp@any$"):
            load_agent(wrong)
    elsewhere = shutil.copytree(SHIPPED / "mlp-all", tmp_path / "mlp-all")
    with pytest.raises(AgentError, match=f"MOVINGOUT_MODELS={tmp_path} is set, or the folder copied to data/models"):
        load_agent(f"onnx:path={elsewhere / 'policy.onnx'}")


def test_the_network_of_a_checkpoint_without_its_card_is_not_taken_for_a_policy_of_ones_own(tmp_path: Path) -> None:
    file = onnx_file(tmp_path / "policy.onnx", 121)
    model = onnx.load(str(file))
    helper.set_model_props(model, {NETWORK_KEY: "{}"})
    onnx.save(model, str(file))
    with pytest.raises(AgentError, match=r"a network of a trained agent without its card\.json; put the whole folder"):
        load_agent(f"onnx:path={file}")


@pytest.mark.parametrize("path", ["~nosuchuser/x.onnx", f"{'x' * 300}.onnx"])
def test_what_can_be_no_file_is_an_unknown_agent(path: str) -> None:
    with pytest.raises(AgentError):
        load_agent(path)
