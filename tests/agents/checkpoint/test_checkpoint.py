"""Checkpoints: what is written is read back, and what is crafted or damaged is refused in a sentence."""

import errno
import json
import os
import pickle
from pathlib import Path

import onnx
import pytest
import torch

from movingout.agents.catalogue import load_agent
from movingout.agents.checkpoint.checkpoint import (
    CARD,
    MODELS_VARIABLE,
    Checkpoint,
    find_checkpoint,
    read_checkpoint,
    write_checkpoint,
)
from movingout.agents.errors import CheckpointError
from movingout.agents.inference.network import Network
from movingout.agents.inference.policy_agent import PolicyAgent
from movingout.agents.kinds.policy import build_policy, weighted_policy
from movingout.agents.policies.export import export, export_policy
from tests.agents.learning import tiny_spec
from tests.agents.trained import load_checkpoint

SPEC = tiny_spec(kind="mlp")


def _card(**changes: object) -> dict[str, object]:
    training = {
        "preset": "fast", "data_sha256": "0" * 64, "population": "A", "episodes": 1, "windows": 2, "updates": 3,
        "seed": 4, "created": "2026-11-21",
    }  # fmt: skip
    return {
        "schema_version": 1, "id": "mlp@test", "name": "MLP", "description": "A test.", "kind": "mlp",
        "maps": ["HandOff"], "policy": SPEC.model_dump(), "training": training, "scores": {}, **changes,
    }  # fmt: skip


def _written(root: Path) -> Checkpoint:
    return write_checkpoint(root / "mlp-test", _card(), {"policy.onnx": export_policy(build_policy(SPEC))})


def _edit(folder: Path, **changes: object) -> None:
    card = json.loads((folder / CARD).read_text())
    (folder / CARD).write_text(json.dumps({**card, **changes}))


def test_a_checkpoint_is_found_by_its_id_and_plays(tmp_path: Path) -> None:
    written = _written(tmp_path)
    found = find_checkpoint("mlp@test", tmp_path / "missing", tmp_path)
    assert found == written and found.card.policy == SPEC
    agent = load_checkpoint(found)
    assert isinstance(agent, PolicyAgent) and agent.spec == SPEC


def test_the_card_names_what_a_network_takes_and_the_file_says_what_it_means(tmp_path: Path) -> None:
    spec = tiny_spec(kind="dp")
    data = export_policy(build_policy(spec))
    written = write_checkpoint(tmp_path / "mlp-test", _card(policy=spec.model_dump()), {"policy.onnx": data})
    (entry,) = written.card.files
    rows = Network(data).input_shapes["noise"][1]
    assert entry.inputs == {
        "observation": ("batch", spec.obs_horizon, spec.features), "noise": ("batch", rows, spec.horizon, 5)
    }  # fmt: skip
    assert entry.outputs == {"chunk": ("batch", spec.horizon, 5)}
    about = json.loads(Network(data).metadata["movingout"])
    assert about == {"network": "policy", **spec.model_dump(mode="json")}
    graph = onnx.load_from_string(data).graph
    assert f"in layout {spec.layout}, not normalised" in graph.input[0].doc_string
    assert "distance, cos and sin of the heading" in graph.output[0].doc_string


def test_cards_of_before_and_shipped_ones_do_without(tmp_path: Path) -> None:
    written = _written(tmp_path)
    (entry,) = json.loads((written.folder / CARD).read_text())["files"]
    _edit(written.folder, files=[{name: entry[name] for name in ("name", "bytes", "sha256")}])
    assert read_checkpoint(written.folder).card.files[0].inputs is None
    assert load_checkpoint(find_checkpoint("mlp@test", tmp_path))


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"surprise": 1}, "Extra inputs are not permitted"),
        ({"schema_version": 2}, "schema_version: Input should be 1, not 2"),
        ({"id": "../../etc"}, "id: String should match"),
        ({"policy": {**SPEC.model_dump(), "width": 10**9}}, "width"),
        ({"policy": {**SPEC.model_dump(), "class_path": "os.system"}}, "class_path"),
        ({"files": [{"name": "../secret", "bytes": 1, "sha256": "0" * 64}]}, "files.0.name"),
        ({"files": [{"name": "policy.onnx", "bytes": 10**12, "sha256": "0" * 64}]}, "files.0.bytes"),
        ({"scores": {"tcr": {"mean": "nan", "stderr": 0.1, "n": 2}}}, "scores"),
        ({"policy": {**SPEC.model_dump(), "layout": "aware-v0"}}, "policy.layout: Input should be 'official-v1'"),
        ({"id": "other@test"}, "lies in folder mlp-test"),
    ],
)
def test_a_card_that_says_more_or_other_than_it_may_is_refused(
    tmp_path: Path, changes: dict[str, object], sentence: str
) -> None:
    folder = _written(tmp_path).folder
    _edit(folder, **changes)
    with pytest.raises(CheckpointError) as raised:
        read_checkpoint(folder)
    assert sentence in str(raised.value)


def test_a_card_that_would_be_refused_is_not_written(tmp_path: Path) -> None:
    with pytest.raises(CheckpointError, match=r"^mlp-test/card.json: description: String should have at most 400"):
        write_checkpoint(tmp_path / "mlp-test", _card(description="d" * 401), {"policy.onnx": b"none"})
    assert list(tmp_path.iterdir()) == []


def test_a_network_of_another_version_of_its_layout_is_to_be_trained_again(tmp_path: Path) -> None:
    checkpoint = _written(tmp_path)
    _edit(checkpoint.folder, policy={**SPEC.model_dump(), "layout": "map-v1"})
    sentence = "takes 278 numbers, and its card says map-v1, which gives 169 here: .*or of another version"
    with pytest.raises(CheckpointError, match=sentence):
        load_checkpoint(read_checkpoint(checkpoint.folder))


def test_a_file_that_the_card_names_may_be_missing_as_in_a_wheel(tmp_path: Path) -> None:
    found = _written(tmp_path)
    assert found.has("policy.onnx") and not found.has("value.onnx")
    (found.folder / "policy.onnx").unlink()
    assert not found.has("policy.onnx")


def test_a_changed_file_is_refused_by_its_hash(tmp_path: Path) -> None:
    checkpoint = _written(tmp_path)
    file = checkpoint.folder / "policy.onnx"
    data = bytearray(file.read_bytes())
    data[-1] ^= 1
    file.write_bytes(data)
    with pytest.raises(CheckpointError, match="is not the file its card describes"):
        load_checkpoint(checkpoint)
    file.unlink()
    file.symlink_to("/etc/hostname")
    with pytest.raises(CheckpointError, match="no plain file"):
        load_checkpoint(checkpoint)


class _Bomb:
    def __reduce__(self) -> tuple[object, tuple[str]]:
        return exec, ("raise SystemExit('the pickle ran')",)


@pytest.mark.parametrize("header", [1 << 30, 5])
def test_weights_that_are_none_are_refused_in_a_sentence(header: int, tmp_path: Path) -> None:
    files = {"policy.onnx": b"none", "policy.safetensors": header.to_bytes(8, "little") + b"{}"}
    written = write_checkpoint(tmp_path / "mlp-test", _card(), files)
    with pytest.raises(CheckpointError, match=r"policy.safetensors of checkpoint mlp@test cannot be read: "):
        weighted_policy(written)


def test_a_pickle_in_the_place_of_a_network_is_refused_without_being_run(tmp_path: Path) -> None:
    checkpoint = write_checkpoint(tmp_path / "mlp-test", _card(), {"policy.onnx": pickle.dumps(_Bomb())})
    with pytest.raises(CheckpointError, match="ONNX"):
        load_checkpoint(checkpoint)


def test_a_network_with_a_forbidden_operator_or_outside_data_is_refused(tmp_path: Path) -> None:
    import onnx
    from onnx import TensorProto, helper

    def model(node: onnx.NodeProto, initializers: list[onnx.TensorProto]) -> bytes:
        value = helper.make_tensor_value_info("x", TensorProto.FLOAT, [1])
        graph = helper.make_graph([node], "g", [value], [helper.make_tensor_value_info("y", TensorProto.FLOAT, [1])])
        graph.initializer.extend(initializers)
        return bytes(helper.make_model(graph).SerializeToString())

    outside = TensorProto(name="w", data_type=TensorProto.FLOAT, dims=[1], data_location=TensorProto.EXTERNAL)
    outside.external_data.add(key="location", value="../../etc/passwd")
    crafted = {
        "operator 'Loop'": model(helper.make_node("Loop", ["x"], ["y"]), []),
        "operators of 'evil'": model(helper.make_node("Add", ["x", "x"], ["y"], domain="evil"), []),
        "in other files, which is not allowed; torch.onnx.export(…, external_data=False)": model(
            helper.make_node("Add", ["x", "w"], ["y"]), [outside]
        ),
        "sparse tensors": model(
            helper.make_node("Constant", [], ["y"], sparse_value=onnx.SparseTensorProto(values=outside, dims=[1])), []
        ),
        "says how to train it": b"\xa2\x01\x00",  # field 20
        "damaged": b"\xba\x80\x80\x80\x10\x00",  # field 7, the graph, for who keeps 32 bits of a tag
    }
    for sentence, data in crafted.items():
        checkpoint = write_checkpoint(tmp_path / "mlp-test", _card(), {"policy.onnx": data})
        with pytest.raises(CheckpointError) as raised:
            load_checkpoint(checkpoint)
        assert sentence in str(raised.value)


def test_a_network_of_another_shape_than_its_card_is_refused(tmp_path: Path) -> None:
    small = export(torch.nn.Linear(3, 3), (torch.zeros(1, 3),), {"observation": ""}, {"chunk": ""}, {})
    other = export_policy(build_policy(tiny_spec(kind="mlp", horizon=4)))
    for data in (small, other):
        checkpoint = write_checkpoint(tmp_path / "mlp-test", _card(), {"policy.onnx": data})
        with pytest.raises(CheckpointError, match="network"):
            load_checkpoint(checkpoint)


@pytest.mark.parametrize(
    ("horizon", "factor", "sentence"),
    [
        (4, 1.0, "the network answers with shape (1, 4, 5), not (1, 8, 5)"),
        (8, float("nan"), "the network answers with numbers that are not finite"),
    ],
)
def test_of_several_agents_the_one_whose_network_cannot_play_is_named(
    horizon: int, factor: float, sentence: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    policy = build_policy(tiny_spec(kind="mlp", horizon=horizon))
    with torch.no_grad():
        for parameter in policy.parameters():
            parameter.mul_(factor)
    write_checkpoint(tmp_path / "mlp-test", _card(), {"policy.onnx": export_policy(policy)})
    monkeypatch.setenv(MODELS_VARIABLE, str(tmp_path))
    with pytest.raises(CheckpointError) as raised:
        load_agent("mlp@test:execute=2")
    assert str(raised.value) == f"mlp@test: {sentence}"


def test_an_unknown_id_is_answered_with_those_that_exist(tmp_path: Path) -> None:
    _written(tmp_path)
    with pytest.raises(CheckpointError, match=r"there are: mlp@test$"):
        find_checkpoint("dp@test", tmp_path)


def test_of_two_ids_with_one_folder_only_the_one_that_lies_there_is_found(tmp_path: Path) -> None:
    write_checkpoint(tmp_path / "mlp-a-b", _card(id="mlp-a@b"), {"policy.onnx": b"x"})
    assert find_checkpoint("mlp-a@b", tmp_path).card.id == "mlp-a@b"
    with pytest.raises(CheckpointError, match=r"no checkpoint 'mlp@a-b'; did you mean mlp-a@b\? there are: mlp-a@b$"):
        find_checkpoint("mlp@a-b", tmp_path)
    with pytest.raises(CheckpointError, match="is the folder of mlp-a@b; choose another id than mlp@a-b"):
        write_checkpoint(tmp_path / "mlp-a-b", _card(id="mlp@a-b"), {"policy.onnx": b"x"})


@pytest.mark.parametrize("fails", ["write_text", "replace"])
def test_a_checkpoint_is_written_wholly_or_not_at_all(
    fails: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = _written(tmp_path)
    real = Path.replace

    def failing(path: Path, *arguments: object, **_: object) -> Path:
        if fails == "replace" and "draft" not in path.name:
            return real(path, *arguments)  # type: ignore[arg-type]
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as full_disk:
        full_disk.setattr(Path, fails, failing)
        with pytest.raises(CheckpointError, match=r"cannot write .*mlp-test: No space left on device"):
            write_checkpoint(before.folder, _card(), {"policy.onnx": b"half"})
    assert find_checkpoint("mlp@test", tmp_path).read("policy.onnx") == before.read("policy.onnx")
    assert [folder.name for folder in tmp_path.iterdir()] == ["mlp-test"]
