"""From a trained network to one ONNX graph, including normalisation and the whole sampler.

Weights are stored in half precision, which halves a checkpoint, and used in single precision.
"""

import json
import tempfile
import warnings
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np
import onnx
import torch
from onnx import helper, numpy_helper
from safetensors.torch import save
from torch import Tensor, nn

from movingout.agents.checkpoint.card import MAX_LINE, OTHER_MAPS, Training
from movingout.agents.checkpoint.checkpoint import Checkpoint, write_checkpoint
from movingout.agents.checkpoint.onnx_interface import NETWORK_KEY
from movingout.agents.checkpoint.onnx_validation import check_onnx
from movingout.agents.checkpoint.policy_spec import ACTION_WIDTH
from movingout.agents.policies.policy import Policy
from movingout.maps.generated.names import PREFIX, is_generated
from movingout.maps.suggestion import shortened
from movingout.maps.symmetry import split_name

OPSET = 17
MOST_MAPS = 60  # on a card by their own names; of more, the first
LARGE = 1024  # numbers; smaller tensors (biases, normalisation) keep full precision


def export_policy(policy: Policy) -> bytes:
    """ONNX of `observation` (B, To, D) and, for policies that draw, `noise` (B, R, H, 5) to `chunk` (B, H, 5)."""
    spec = policy.spec
    observation = torch.zeros(2, spec.obs_horizon, spec.features)
    noise = torch.zeros(2, max(policy.noise_rows, 1), spec.horizon, ACTION_WIDTH)
    inputs = {"observation": f"the last {spec.obs_horizon} observations in layout {spec.layout}, not normalised"}
    if policy.noise_rows:
        inputs["noise"] = "numbers of the standard normal distribution, drawn anew for each chunk"
    outputs = {"chunk": "per tick: distance, cos and sin of the heading, and scores of grasping no and yes"}
    return export(policy, (observation, noise), inputs, outputs, {"network": "policy", **spec.model_dump()})


def export(
    module: nn.Module, example: tuple[Tensor, ...], inputs: Mapping[str, str], outputs: Mapping[str, str],
    about: Mapping[str, object],
) -> bytes:  # fmt: skip
    """ONNX of a module with a dynamic batch axis.

    `inputs` and `outputs` say what each is, by name, in the order of the module's; `about` becomes the file's metadata
    `movingout`, as JSON. Raises CheckpointError if loading would refuse the result.
    """
    module = module.eval().cpu()
    free = {name: {0: "batch"} for name in (*inputs, *outputs)}
    with tempfile.TemporaryDirectory() as folder, torch.inference_mode(), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about the newer exporter, which needs two more packages
        path = Path(folder) / "network.onnx"
        torch.onnx.export(
            module, example, path, input_names=list(inputs), output_names=list(outputs), dynamic_axes=free,
            opset_version=OPSET, dynamo=False,
        )  # fmt: skip
        made = module(*example)
        shapes = [tensor.shape for tensor in ((made,) if isinstance(made, Tensor) else made)]
        data = _described(_halved(path.read_bytes()), {**inputs, **outputs}, shapes, about)
    check_onnx(data)
    return data


def _described(
    data: bytes, meanings: Mapping[str, str], made: Iterable[Sequence[int]], about: Mapping[str, object]
) -> bytes:
    """The model with what its values mean, for whoever has the file without its card.

    `made` are the shapes of its outputs; of them the exporter does not always know more than their number.
    """
    model = onnx.load_from_string(data)
    for value in (*model.graph.input, *model.graph.output):
        value.doc_string = meanings[value.name]
    for value, shape in zip(model.graph.output, made, strict=True):
        kind = value.type.tensor_type.elem_type
        value.type.CopyFrom(helper.make_tensor_type_proto(kind, ["batch", *shape[1:]]))
    helper.set_model_props(model, {NETWORK_KEY: json.dumps(about)})
    described: bytes = model.SerializeToString()
    return described


def halved_weights(module: nn.Module) -> dict[str, Tensor]:
    """The parameters and buffers of a module, large ones in half precision, to be stored beside its ONNX."""
    return {
        name: (tensor.half() if _is_halved(tensor.dtype == torch.float32, tensor.numel()) else tensor).contiguous()
        for name, tensor in module.state_dict().items()
    }


def save_policy(
    folder: Path, agent_id: str, policy: Policy, maps: Iterable[str], training: Training, name: str, description: str
) -> Checkpoint:
    """Write the checkpoint folder: card, ONNX and safetensors."""
    policy = policy.eval().cpu()
    card = {
        "schema_version": 1,
        "id": agent_id,
        "name": name,
        "description": shortened(description, MAX_LINE),  # partners, maps and populations may have many names
        "kind": policy.spec.kind,
        "maps": card_maps(maps),
        "policy": policy.spec.model_dump(),
        "training": training.model_dump(),
    }
    return write_checkpoint(
        folder, card, {"policy.onnx": export_policy(policy), "policy.safetensors": save(halved_weights(policy))}
    )


def card_maps(names: Iterable[str]) -> list[str]:
    """The maps of a card: thousands of generated ones are one word, and many symmetries of a map are its name.

    Of more maps than a card has room for, a word stands for those after the first.
    """
    maps = {PREFIX if is_generated(name) else name for name in names}
    if len(maps) > MOST_MAPS:
        maps = {split_name(name)[0] for name in maps}
    named = sorted(maps - {PREFIX, OTHER_MAPS})
    others = [OTHER_MAPS] if OTHER_MAPS in maps or len(named) > MOST_MAPS else []
    return [*sorted([*named[:MOST_MAPS], *(maps & {PREFIX})]), *others]


def _is_halved(single: bool, numbers: int) -> bool:
    return single and numbers >= LARGE


def _halved(data: bytes) -> bytes:
    """The model with its large weights stored as float16, each cast back where it was; onnxruntime does it at load."""
    model = onnx.load_from_string(data)
    casts = []
    for tensor in model.graph.initializer:
        values = numpy_helper.to_array(tensor)
        if not _is_halved(values.dtype == np.float32, values.size):
            continue
        name = tensor.name
        tensor.CopyFrom(numpy_helper.from_array(values.astype(np.float16), f"{name}.half"))
        casts.append(helper.make_node("Cast", [tensor.name], [name], to=onnx.TensorProto.FLOAT))
    nodes = [*casts, *model.graph.node]
    del model.graph.node[:]
    model.graph.node.extend(nodes)
    halved: bytes = model.SerializeToString()
    return halved
