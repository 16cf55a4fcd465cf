"""A model in onnxruntime, checked against its manifest.

Operators of an ONNX model that draw random numbers: with one, equal inputs give different actions.

onnxruntime shows no nodes of a model, so that its file is read as protobuf messages; the numbers of their fields are
those of onnx.proto, https://github.com/onnx/onnx/blob/main/onnx/onnx.proto.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vpf_sim.drivers.learned.manifest import Manifest, file_of
from vpf_sim.errors import InputError
from vpf_sim.types import Floats, Singles

INSTALL = "expected onnxruntime, which is not installed: pip install 'vpf_sim[onnx]'"
FLOAT = "tensor(float)"
ACTION = (1, 2)
SURE = "expected a model that gives equal actions for equal inputs, such as the mean of a stochastic policy"
MOST_LISTED = 3  # operators in a message
FATAL = 4  # the least talkative of onnxruntime's levels: faults are raised anyway
RANDOM = frozenset(
    {
        "Bernoulli",
        "Multinomial",
        "RandomNormal",
        "RandomNormalLike",
        "RandomUniform",
        "RandomUniformLike",
        "Sampling",  # this and the next ones are onnxruntime's own
        "BiasDropout",
        "BitmaskBiasDropout",
        "BitmaskDropout",
    }
)
DROPOUT, TRAINING_MODE = "Dropout", 2  # random only with its third input
MODEL_GRAPH, MODEL_FUNCTION = 7, 25
GRAPH_NODE, GRAPH_INITIALIZER = 1, 5
FUNCTION_NAME, FUNCTION_NODE = 1, 7
NODE_INPUT, NODE_OUTPUT, NODE_NAME, NODE_TYPE, NODE_ATTRIBUTE = 1, 2, 3, 4, 5
ATTRIBUTE_GRAPHS = (6, 11)
ATTRIBUTE_TENSOR = 5
TENSOR_INTS, TENSOR_NAME, TENSOR_BYTES = 5, 8, 9

Fields = list[tuple[int, Any]]  # number and value of each field; bytes where it is a text or a message


@dataclass(frozen=True, slots=True)
class Node:
    """A node of a graph; `inner` are those of its subgraphs, such as the branches of an If."""

    kind: str
    name: str
    inputs: list[str]
    outputs: list[str]
    inner: "list[Node]"


def random_operators(model: bytes, output: str) -> list[str]:
    """The random operators that an output depends on, each as "RandomNormalLike 'noise'"."""
    fields = _fields(model)
    functions = {_text(body, FUNCTION_NAME): _nodes(body, FUNCTION_NODE) for body in _messages(fields, MODEL_FUNCTION)}
    found: list[str] = []
    for graph in _messages(fields, MODEL_GRAPH):
        needed, off = {output}, _false_constants(graph)
        for node in reversed(_nodes(graph, GRAPH_NODE)):  # a node comes after those whose outputs it takes
            if needed & set(node.outputs):
                needed |= {name for one in _with_inner(node) for name in one.inputs}
                found += _random(node, functions, off)
    return list(dict.fromkeys(reversed(found)))


def _random(node: Node, functions: dict[str, list[Node]], off: set[str]) -> Iterator[str]:
    """The random operators of a node, of its subgraphs, and of the model's own functions that it calls."""
    for one in _with_inner(node):
        mode = one.inputs[TRAINING_MODE] if len(one.inputs) > TRAINING_MODE else ""
        if one.kind in RANDOM or (one.kind == DROPOUT and mode and mode not in off):
            yield f"{one.kind} '{one.name or one.outputs[0]}'"
        others = {name: body for name, body in functions.items() if name != one.kind}  # none calls itself
        for inner in functions.get(one.kind, []):
            yield from _random(inner, others, off)


def _with_inner(node: Node) -> Iterator[Node]:
    yield node
    for inner in node.inner:
        yield from _with_inner(inner)


def _nodes(graph: Fields, number: int) -> list[Node]:
    return [
        Node(
            _text(fields, NODE_TYPE),
            _text(fields, NODE_NAME),
            _texts(fields, NODE_INPUT),
            _texts(fields, NODE_OUTPUT),
            [
                inner
                for attribute in _messages(fields, NODE_ATTRIBUTE)
                for place in ATTRIBUTE_GRAPHS
                for subgraph in _messages(attribute, place)
                for inner in _nodes(subgraph, GRAPH_NODE)
            ],
        )
        for fields in _messages(graph, number)
    ]


def _false_constants(graph: Fields) -> set[str]:
    """Names of constants of a graph that are false."""
    named = [(_text(tensor, TENSOR_NAME), tensor) for tensor in _messages(graph, GRAPH_INITIALIZER)]
    for fields in _messages(graph, GRAPH_NODE):
        if _text(fields, NODE_TYPE) == "Constant":
            tensors = [
                tensor
                for attribute in _messages(fields, NODE_ATTRIBUTE)
                for tensor in _messages(attribute, ATTRIBUTE_TENSOR)
            ]
            named += [(_texts(fields, NODE_OUTPUT)[0], tensor) for tensor in tensors]
    return {name for name, tensor in named if _is_false(tensor)}


def _is_false(tensor: Fields) -> bool:
    values = [value for number, value in tensor if number in (TENSOR_INTS, TENSOR_BYTES)]
    return bool(values) and not any(any(value) if isinstance(value, bytes) else value for value in values)


def _fields(message: bytes) -> Fields:
    """The fields of a message of which nothing is known."""
    from google.protobuf.empty_pb2 import Empty
    from google.protobuf.unknown_fields import UnknownFieldSet

    parsed = Empty()
    parsed.ParseFromString(message)
    return [(field.field_number, field.data) for field in UnknownFieldSet(parsed)]


def _messages(fields: Fields, number: int) -> Iterator[Fields]:
    return (_fields(value) for place, value in fields if place == number)


def _texts(fields: Fields, number: int) -> list[str]:
    return [value.decode("utf-8", "replace") for place, value in fields if place == number]


def _text(fields: Fields, number: int) -> str:
    return next(iter(_texts(fields, number)), "")


class Session:
    """A model that maps a policy's inputs to its action, on one thread: equal inputs give equal actions."""

    def __init__(self, model: Path, manifest: Manifest) -> None:
        self._outputs = [*manifest.outputs.values()]
        content = _content(model)
        self._session = _opened(model, content)
        faults = [*_faults(self._session, manifest, model)]
        used = [one for output in self._outputs for one in random_operators(content, output)]
        if operators := [*dict.fromkeys(used)]:
            faults.append(f"{model}: {SURE}, got the random operator {', '.join(operators[:MOST_LISTED])}")
        if faults:
            raise InputError("\n".join(faults))

    def run(self, inputs: dict[str, Singles]) -> list[Floats]:
        """(2,) throttle and steering, then (2,) their standard deviations where the manifest names them."""
        return [found[0].astype(float) for found in self._session.run(self._outputs, inputs)]


def _content(model: Path) -> bytes:
    try:
        return model.read_bytes()
    except OSError as error:
        raise InputError(f"{model}: expected a readable ONNX model, got: {error.strerror}") from None


def _opened(model: Path, content: bytes) -> Any:
    """The session; InputError without onnxruntime, or where the content is no model."""
    try:
        import onnxruntime
    except ImportError:
        raise InputError(f"{model}: {INSTALL}") from None
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.log_severity_level = FATAL
    try:
        return onnxruntime.InferenceSession(content, options, providers=["CPUExecutionProvider"])
    except Exception as error:  # onnxruntime has its own exceptions, which are not public
        reason = " ".join(str(error).split())[:200]
        raise InputError(f"{model}: expected an ONNX model in one file, got: {reason}") from None


def _faults(session: Any, manifest: Manifest, model: Path) -> Iterator[str]:
    """Each place where model and manifest differ: file, key, expected, actual."""
    toml, ours = file_of(model), {key: given for key in ("image", "state") if (given := getattr(manifest, key))}
    inputs = {one.name: one for one in session.get_inputs()}
    for key, given in ours.items():
        if given.input not in inputs:
            yield f"{toml}: {key}.input: expected an input of {model.name}, {_named(inputs)}, got '{given.input}'"
            continue
        tensor = inputs[given.input]
        if tensor.type != FLOAT:
            yield f"{model}: input '{tensor.name}': expected {FLOAT}, got {tensor.type}"
        if not _fits(tensor.shape, given.shape):
            has = f"the shape of '{tensor.name}' in {model.name}, {_shape(tensor.shape)}"
            yield f"{toml}: {key}: expected {has}, got {_shape(given.shape)}"
    unused = inputs.keys() - {given.input for given in ours.values()}
    if len(inputs) > len(ours):
        yield f"{toml}: expected [image] or [state] for each input of {model.name}, got none for {_named(unused)}"
    outputs = {one.name: one for one in session.get_outputs()}
    for key, name in manifest.outputs.items():
        if name not in outputs:
            yield f"{toml}: {key}: expected an output of {model.name}, {_named(outputs)}, got '{name}'"
            continue
        tensor = outputs[name]
        if tensor.type != FLOAT or not _fits(tensor.shape, ACTION):
            wanted = f"{FLOAT} of shape {_shape(ACTION)}, throttle and steering"
            yield f"{model}: output '{name}': expected {wanted}, got {tensor.type} of {_shape(tensor.shape)}"


def _fits(actual: Sequence[Any], expected: Sequence[int]) -> bool:
    """Whether shapes agree; a dimension that the model leaves open fits any."""
    pairs = zip(actual, expected, strict=False)
    return len(actual) == len(expected) and all(not isinstance(has, int) or has == want for has, want in pairs)


def _shape(shape: Sequence[Any]) -> str:
    return f"({', '.join(str(size) for size in shape)})"


def _named(names: Iterable[str]) -> str:
    return " or ".join(f"'{name}'" for name in sorted(names))
