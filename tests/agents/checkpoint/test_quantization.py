"""Agents with weights of 8 bits: nearly the same networks, in half the space, and what they have in common once."""

import shutil
from pathlib import Path

import numpy as np
import onnx
import pytest
import torch
from onnx import TensorProto

from movingout.agents.checkpoint.checkpoint import (
    SHIPPED,
    Checkpoint,
    find_checkpoint,
    folder_name,
    read_checkpoint,
    write_checkpoint,
)
from movingout.agents.checkpoint.quantization import LARGE, quantized, quantized_onnx, write_quantized
from movingout.agents.errors import CheckpointError
from movingout.agents.inference.network import Network
from movingout.agents.kinds.policy import build_policy
from movingout.agents.policies.export import export, save_policy
from movingout.server.cli import main
from tests.agents.trained import load_checkpoint


def test_a_weight_is_off_by_half_a_step_of_its_row_or_column_at_most() -> None:
    random = np.random.default_rng(0)
    rows = random.standard_normal((40, 60)).astype(np.float32) * np.logspace(-3, 3, 40, dtype=np.float32)[:, None]
    for weights in (rows, rows.T, np.stack((rows, rows))[:1], np.zeros((3, 4), dtype=np.float32)):
        integers, scales = quantized(weights)
        assert integers.dtype == np.int8 and integers.shape == weights.shape
        assert (np.abs(integers * scales - weights) <= scales * 0.5001).all()
    assert quantized(rows)[1].shape == (40, 1) and quantized(rows.T)[1].shape == (1, 40)


def _untrained(agent_id: str, root: Path) -> Checkpoint:
    """An agent shaped as a shipped one, in half precision, whose weights are the first ones of a training."""
    shipped = find_checkpoint(agent_id, SHIPPED).card
    torch.manual_seed(0)
    policy, folder = build_policy(shipped.network), root / folder_name(agent_id)
    return save_policy(folder, agent_id, policy, shipped.maps, shipped.training, shipped.name, "untrained")


@pytest.mark.parametrize("agent_id", ["mlp@all", "gru@all"])
def test_a_network_answers_nearly_the_same_from_half_the_bytes(agent_id: str, tmp_path: Path) -> None:
    checkpoint = _untrained(agent_id, tmp_path)
    data = checkpoint.read("policy.onnx")
    small = quantized_onnx(data)
    assert len(small) < 0.55 * len(data)
    kinds = {
        tensor.data_type for tensor in onnx.load_from_string(small).graph.initializer if np.prod(tensor.dims) > 4096
    }
    assert kinds == {TensorProto.INT8}
    spec = checkpoint.card.network
    seen = np.random.default_rng(0).standard_normal((64, spec.obs_horizon, spec.features)).astype(np.float32)
    before, after = (Network(each)(observation=seen)[0] for each in (data, small))
    off, spread = np.sqrt(np.square(after - before).mean()), before.std()
    assert 0 < off < 0.03 * spread
    assert quantized_onnx(small) == small


def test_weights_in_single_precision_are_quantized_too() -> None:
    module = torch.nn.Sequential(torch.nn.Linear(8, LARGE), torch.nn.ReLU(), torch.nn.Linear(LARGE, 2))
    model = onnx.load_from_string(export(module, (torch.zeros(2, 8),), {"seen": ""}, {"answer": ""}, {}))
    for node in [node for node in model.graph.node if node.op_type == "Cast"]:
        tensor = next(one for one in model.graph.initializer if one.name == node.input[0])
        values = onnx.numpy_helper.to_array(tensor).astype(np.float32)
        tensor.CopyFrom(onnx.numpy_helper.from_array(values, node.output[0]))
        model.graph.node.remove(node)
    data = model.SerializeToString()
    seen = np.random.default_rng(0).standard_normal((16, 8)).astype(np.float32)
    before, after = (Network(each)(seen=seen)[0] for each in (data, quantized_onnx(data)))
    assert len(quantized_onnx(data)) < 0.55 * len(data)
    assert np.allclose(before, after, atol=0.05) and not np.array_equal(before, after)


def _twin(root: Path) -> tuple[Checkpoint, Checkpoint]:
    """A shipped agent, and another one with the same network."""
    one = find_checkpoint("mlp@all", SHIPPED)
    card = {**one.card.model_dump(exclude={"files"}), "id": "mlp@twin"}
    return one, write_checkpoint(root / "mlp-twin", card, {"policy.onnx": one.read("policy.onnx")})


def test_a_network_in_common_is_stored_once_and_both_agents_play(tmp_path: Path) -> None:
    small = tmp_path / "small"
    first, second = (write_quantized(each, small) for each in _twin(tmp_path))
    assert [entry.of for entry in (*first.card.files, *second.card.files)] == [None, "mlp@all"]
    assert sorted(path.name for path in second.folder.iterdir()) == ["card.json"]
    assert second.has("policy.onnx") and second.read("policy.onnx") == first.read("policy.onnx")
    assert not first.card.scores and first.card.training == find_checkpoint("mlp@all", SHIPPED).card.training
    assert load_checkpoint(read_checkpoint(second.folder))
    (first.folder / "policy.onnx").write_bytes(b"other")
    with pytest.raises(CheckpointError, match="is not the file its card describes"):
        second.read("policy.onnx")
    shutil.rmtree(first.folder)
    with pytest.raises(CheckpointError, match=r"has policy.onnx in common with mlp@all; copy that agent beside it"):
        second.read("policy.onnx")
    assert not second.has("policy.onnx")


def test_the_command_says_what_was_gained_and_refuses_the_own_folder(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    _untrained("mlp@all", tmp_path / "data" / "models")
    monkeypatch.chdir(tmp_path)
    assert main(["agents", "quantize", "mlp@all", "--out", "small"]) == 0
    assert "mlp@all: 2.8 MB, now 0.7 MB" in capsys.readouterr().out
    assert main(["agents", "quantize", "mlp@all", "--out", "kept", "--keep-weights"]) == 0
    before, now = (Path(root) / "mlp-all" / "policy.safetensors" for root in ("data/models", "kept"))
    assert now.read_bytes() == before.read_bytes()
    assert main(["agents", "quantize", "mlp@all", "--out", "data/models"]) == 2
    assert "lies in" in capsys.readouterr().err
