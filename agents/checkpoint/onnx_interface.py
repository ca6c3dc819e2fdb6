"""What an ONNX file takes and gives: the names and shapes of its inputs and outputs, read without the package onnx."""

from collections.abc import Iterator

from movingout.agents.checkpoint.onnx_validation import wire_fields, wire_message

Shapes = dict[str, tuple[int | str, ...]]
"""By name; a length that is left open is a word, such as "batch"."""

NETWORK_KEY = "movingout"
"""Metadata of the networks of checkpoints: the shape of the network, as JSON."""

# Field numbers of onnx.proto.
_MODEL_GRAPH = 7
_GRAPH_INPUT, _GRAPH_OUTPUT = 11, 12
_VALUE_NAME, _VALUE_TYPE = 1, 2
_TYPE_TENSOR = 1
_TENSOR_SHAPE = 2
_SHAPE_DIM = 1
_DIM_VALUE, _DIM_WORD = 1, 2


def onnx_interface(data: bytes) -> tuple[Shapes, Shapes]:
    """The inputs and the outputs of a model. Raises CheckpointError for a damaged one."""
    values: dict[int, Shapes] = {_GRAPH_INPUT: {}, _GRAPH_OUTPUT: {}}
    for graph in _below(memoryview(data), _MODEL_GRAPH):
        for field, shapes in values.items():
            for value in _below(graph, field):
                shapes |= {bytes(name).decode("utf-8", "replace"): _shape(value) for name in _below(value, _VALUE_NAME)}
    return values[_GRAPH_INPUT], values[_GRAPH_OUTPUT]


def _shape(value: memoryview) -> tuple[int | str, ...]:
    return tuple(
        _length(dimension)
        for kind in _below(value, _VALUE_TYPE)
        for tensor in _below(kind, _TYPE_TENSOR)
        for shape in _below(tensor, _TENSOR_SHAPE)
        for dimension in _below(shape, _SHAPE_DIM)
    )


def _length(dimension: memoryview) -> int | str:
    for field, value in wire_fields(dimension):
        if field == _DIM_VALUE and isinstance(value, int):
            return value
        if field == _DIM_WORD:
            return bytes(wire_message(value)).decode("utf-8", "replace")
    return "any"


def _below(message: memoryview, wanted: int) -> Iterator[memoryview]:
    """The messages in a field of a message."""
    return (wire_message(value) for field, value in wire_fields(message) if field == wanted)
