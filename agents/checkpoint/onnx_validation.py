"""Refuses ONNX files that are more than a small self-contained network, before anything is built from them.

Reads the protobuf wire format directly, with no schema: only field numbers of onnx.proto that matter here.
"""

from collections.abc import Iterator

from movingout.agents.errors import CheckpointError

# What networks are made of, recurrent ones too; the branches of an If are checked like the graph around it. Left out:
# what repeats a graph as often as it likes (Loop, Scan), draws numbers of its own (RandomNormal, …), works with texts,
# lists or optional values, or belongs to training.
ALLOWED_OPERATORS = frozenset(
    {
        "Abs", "Acos", "Add", "And", "ArgMax", "ArgMin", "Asin", "Atan", "Atanh", "Attention", "AveragePool",
        "BatchNormalization", "Cast", "CastLike", "Ceil", "Celu", "Clip", "Concat", "Constant", "ConstantOfShape",
        "Conv", "ConvTranspose", "Cos", "CumSum", "DepthToSpace", "DequantizeLinear", "Div", "Dropout",
        "DynamicQuantizeLinear", "Einsum", "Elu", "Equal", "Erf", "Exp", "Expand", "Flatten", "Floor", "GRU", "Gather",
        "GatherElements", "GatherND", "Gelu", "Gemm", "GlobalAveragePool", "GlobalMaxPool", "Greater", "GreaterOrEqual",
        "GroupNormalization", "HardSigmoid", "HardSwish", "Hardmax", "Identity", "If", "InstanceNormalization", "IsInf",
        "IsNaN", "LSTM", "LayerNormalization", "LeakyRelu", "Less", "LessOrEqual", "Log", "LogSoftmax", "MatMul",
        "MatMulInteger", "Max", "MaxPool", "Mean", "Min", "Mish", "Mod", "Mul", "Neg", "Not", "OneHot", "Or", "PRelu",
        "Pad", "Pow", "QuantizeLinear", "RMSNormalization", "RNN", "Range", "Reciprocal", "ReduceL1", "ReduceL2",
        "ReduceLogSum", "ReduceLogSumExp", "ReduceMax", "ReduceMean", "ReduceMin", "ReduceProd", "ReduceSum",
        "ReduceSumSquare", "Relu", "Reshape", "Resize", "RotaryEmbedding", "Round", "ScatterElements", "ScatterND",
        "Selu", "Shape", "Sigmoid", "Sign", "Sin", "Size", "Slice", "Softmax", "Softplus", "Softsign", "SpaceToDepth",
        "Split", "Sqrt", "Squeeze", "Sub", "Sum", "Swish", "Tan", "Tanh", "ThresholdedRelu", "Tile", "TopK",
        "Transpose", "Trilu", "Unsqueeze", "Where", "Xor",
    }
)  # fmt: skip
MAX_DEPTH = 4  # of graphs within attributes

# Field numbers of onnx.proto.
_MODEL_GRAPH, _MODEL_TRAINING, _MODEL_FUNCTIONS = 7, 20, 25
_GRAPH_NODE, _GRAPH_INITIALIZER, _GRAPH_SPARSE = 1, 5, 15
_NODE_OPERATOR, _NODE_ATTRIBUTE, _NODE_DOMAIN = 4, 5, 7
_ATTRIBUTE_TENSOR, _ATTRIBUTE_GRAPH, _ATTRIBUTE_TENSORS, _ATTRIBUTE_GRAPHS = 5, 6, 10, 11
_ATTRIBUTE_SPARSE = (22, 23)
_TENSOR_EXTERNAL, _TENSOR_LOCATION = 13, 14
_MAX_TAG = 2**32 - 1


def check_onnx(data: bytes) -> None:
    """Raise CheckpointError unless the model uses allowed operators only and keeps all its data inside."""
    graphs = 0
    for field, value in wire_fields(memoryview(data)):
        if field == _MODEL_FUNCTIONS:
            raise CheckpointError("the ONNX file defines its own functions, which are not allowed")
        if field == _MODEL_TRAINING:
            raise CheckpointError("the ONNX file says how to train it, which is not allowed")
        if field == _MODEL_GRAPH:
            graphs += 1
            _check_graph(wire_message(value), 0)
    if graphs != 1:
        raise CheckpointError("this is not an ONNX model: it has no graph")


def _check_graph(graph: memoryview, depth: int) -> None:
    if depth > MAX_DEPTH:
        raise CheckpointError("the ONNX file nests graphs too deeply")
    for field, value in wire_fields(graph):
        if field == _GRAPH_NODE:
            _check_node(wire_message(value), depth)
        elif field == _GRAPH_INITIALIZER:
            _check_tensor(wire_message(value))
        elif field == _GRAPH_SPARSE:
            raise CheckpointError("the ONNX file has sparse tensors, which are not allowed")


def _check_node(node: memoryview, depth: int) -> None:
    for field, value in wire_fields(node):
        if field == _NODE_OPERATOR:
            name = bytes(wire_message(value)).decode("ascii", "replace")
            if name not in ALLOWED_OPERATORS:
                raise CheckpointError(f"the ONNX file uses the operator {name!r}, which is not allowed")
        elif field == _NODE_DOMAIN:
            domain = bytes(wire_message(value)).decode("ascii", "replace")
            if domain not in ("", "ai.onnx"):
                raise CheckpointError(f"the ONNX file uses operators of {domain!r}; only the standard ones are allowed")
        elif field == _NODE_ATTRIBUTE:
            _check_attribute(wire_message(value), depth)


def _check_attribute(attribute: memoryview, depth: int) -> None:
    for field, value in wire_fields(attribute):
        if field in (_ATTRIBUTE_TENSOR, _ATTRIBUTE_TENSORS):
            _check_tensor(wire_message(value))
        elif field in (_ATTRIBUTE_GRAPH, _ATTRIBUTE_GRAPHS):
            _check_graph(wire_message(value), depth + 1)
        elif field in _ATTRIBUTE_SPARSE:
            raise CheckpointError("the ONNX file has sparse tensors, which are not allowed")


def _check_tensor(tensor: memoryview) -> None:
    for field, value in wire_fields(tensor):
        if field == _TENSOR_EXTERNAL or (field == _TENSOR_LOCATION and value != 0):
            raise CheckpointError(
                "the ONNX file keeps data in other files, which is not allowed; torch.onnx.export(…, "
                "external_data=False) keeps it inside, as does onnx.save(onnx.load(FILE), FILE)"
            )


def wire_message(value: memoryview | int) -> memoryview:
    """A field that holds a message or bytes. Raises CheckpointError for a number."""
    if isinstance(value, int):
        raise CheckpointError("the ONNX file is damaged")
    return value


def wire_fields(data: memoryview) -> Iterator[tuple[int, memoryview | int]]:
    """The fields of one message: varints as numbers, everything else as bytes. Raises CheckpointError."""
    position = 0
    while position < len(data):
        tag, position = _varint(data, position)
        if tag > _MAX_TAG:  # the runtime would take its low bits, and see another field than we
            raise CheckpointError("the ONNX file is damaged")
        kind = tag & 7
        if kind == 0:
            number, position = _varint(data, position)
            yield tag >> 3, number
            continue
        if kind == 2:
            size, position = _varint(data, position)
        elif kind in (1, 5):
            size = 8 if kind == 1 else 4
        else:
            raise CheckpointError("the ONNX file is damaged")
        if position + size > len(data):
            raise CheckpointError("the ONNX file is cut off")
        yield tag >> 3, data[position : position + size]
        position += size


def _varint(data: memoryview, position: int) -> tuple[int, int]:
    value = shift = 0
    while position < len(data) and shift < 64:
        byte = data[position]
        position += 1
        value |= (byte & 0x7F) << shift
        if byte < 0x80:
            return value, position
        shift += 7
    raise CheckpointError("the ONNX file is cut off")
