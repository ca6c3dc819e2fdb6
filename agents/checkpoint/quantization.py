"""Trained agents made small: large weights as 8-bit integers, each row or column of them with a scale of its own.

Weights only, and symmetric: a weight is its integer times its scale, multiplied in single precision when the network is
loaded, so that every machine gets the same weights. The arithmetic of the network stays what it was.
"""

from pathlib import Path

import numpy as np
import numpy.typing as npt
import onnx
from onnx import NodeProto, TensorProto, helper, numpy_helper

from movingout.agents.checkpoint.checkpoint import Checkpoint, folder_name, write_checkpoint
from movingout.agents.checkpoint.onnx_validation import check_onnx
from movingout.agents.errors import CheckpointError

LARGE = 1024  # numbers; smaller tensors (biases, normalisation) keep their precision
LEVELS = 127  # on each side of zero
Weights = npt.NDArray[np.float32]


def write_quantized(checkpoint: Checkpoint, root: Path, keep_weights: bool = False) -> Checkpoint:
    """Write the agent into `root` with quantized networks.

    `keep_weights`: with the weights that they were made from, to train on; else without what does not play.
    A network that an agent there has already is not written again. Scores are left out: they are of other weights.
    Raises CheckpointError when the agent lies in `root` itself.
    """
    card = checkpoint.card
    folder = root / folder_name(card.id)
    if folder.resolve() == checkpoint.folder.resolve():
        raise CheckpointError(f"{card.id} lies in {root} itself; name another folder with --out")
    names = [entry.name for entry in card.files if entry.name.endswith(".onnx")]
    files = {name: quantized_onnx(checkpoint.read(name)) for name in names}
    if keep_weights:
        weights = [entry.name for entry in card.files if entry.name.endswith(".safetensors")]
        files |= {name: checkpoint.read(name) for name in weights}
    return write_checkpoint(folder, card.model_dump(exclude={"files", "scores"}), files, share=True)


def quantized_onnx(data: bytes) -> bytes:
    """The model with its large float weights, stored in half or single precision, as integers with scales.

    Integers stay as they are. Raises CheckpointError for a model that could not be loaded.
    """
    check_onnx(data)
    model = onnx.load_from_string(data)
    weights = {tensor.name: tensor for tensor in model.graph.initializer if _is_large(tensor)}
    nodes, quantized = [], set()
    for node in model.graph.node:
        if node.op_type == "Cast" and node.input[0] in weights:  # a weight in half precision
            quantized.add(node.input[0])
            nodes += _replace(model, weights[node.input[0]], node.output[0])
        else:
            nodes.append(node)
    singles = [tensor for name, tensor in weights.items() if name not in quantized]
    first = [node for tensor in singles for node in _replace(model, tensor, tensor.name)]
    del model.graph.node[:]
    model.graph.node.extend([*first, *nodes])
    small: bytes = model.SerializeToString()
    check_onnx(small)
    return small


def quantized(weights: Weights) -> tuple[npt.NDArray[np.int8], Weights]:
    """Integers of the shape of the weights, and the scales by which they are multiplied (of the same rank).

    There is a scale for each index of one axis: of the axis that leaves the smallest error.
    """
    found = [_along(weights, axis) for axis, length in enumerate(weights.shape) if length > 1]
    return min(found, key=lambda pair: float(np.square(pair[0] * pair[1] - weights).sum()))


def _along(weights: Weights, axis: int) -> tuple[npt.NDArray[np.int8], Weights]:
    others = tuple(other for other in range(weights.ndim) if other != axis)
    largest = np.abs(weights).max(axis=others, keepdims=True)
    scales = np.where(largest > 0, largest / LEVELS, 1.0).astype(np.float32)
    return np.round(weights / scales).astype(np.int8), scales


def _is_large(tensor: TensorProto) -> bool:
    kinds = TensorProto.FLOAT, TensorProto.FLOAT16
    matrix = sum(length > 1 for length in tensor.dims) > 1
    return tensor.data_type in kinds and matrix and int(np.prod(tensor.dims)) >= LARGE


def _replace(model: onnx.ModelProto, tensor: TensorProto, name: str) -> list[NodeProto]:
    """Store a tensor as integers and scales in its place; the nodes that make the float tensor `name` of them."""
    integers, scales = quantized(numpy_helper.to_array(tensor).astype(np.float32))
    tensor.CopyFrom(numpy_helper.from_array(integers, f"{name}.int8"))
    model.graph.initializer.append(numpy_helper.from_array(scales, f"{name}.scales"))
    cast = helper.make_node("Cast", [f"{name}.int8"], [f"{name}.float"], to=TensorProto.FLOAT)
    return [cast, helper.make_node("Mul", [f"{name}.float", f"{name}.scales"], [name])]
