"""Operators of an ONNX model that draw random numbers: with one, equal inputs give different actions.

onnxruntime shows no nodes of a model, so that its file is read as protobuf messages; the numbers of their fields are
those of onnx.proto, https://github.com/onnx/onnx/blob/main/onnx/onnx.proto.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

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
