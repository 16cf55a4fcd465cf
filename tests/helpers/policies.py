"""Small ONNX policies with known answers, and their manifests."""

from collections.abc import Callable, Sequence
from pathlib import Path

import onnx
from onnx import TensorProto, helper

Parts = tuple[list[onnx.NodeProto], list[onnx.TensorProto]]
IMAGE, STATE = (1, 1, 6, 8), (1, 2)
MANIFEST = """schema = 1
rate_hz = 20.0
[image]
width_px = 8
height_px = 6
[state]
values = ["throttle", "steering"]
"""


def constant(*action: float) -> Parts:
    """A policy that always answers the same."""
    value = helper.make_tensor("value", TensorProto.FLOAT, (1, len(action)), action)
    return [helper.make_node("Identity", ["value"], ["action"])], [value]


def last_action_plus(throttle: float, steering: float) -> Parts:
    """A policy that adds to its last action, which is the state."""
    value = helper.make_tensor("value", TensorProto.FLOAT, (1, 2), [throttle, steering])
    return [helper.make_node("Add", ["state", "value"], ["action"])], [value]


def ends_of_the_picture() -> Parts:
    """A policy that answers the first and the last value of its picture."""
    ends = helper.make_tensor("ends", TensorProto.INT64, (1, 2), [0, -1])
    flat = helper.make_node("Flatten", ["image"], ["flat"])
    return [flat, helper.make_node("GatherElements", ["flat", "ends"], ["action"], axis=1)], [ends]


def unsure_as_the_picture_ends(*action: float) -> Parts:
    """A policy that always does the same, with the first and the last value of its picture as deviation."""
    nodes, constants = constant(*action)
    (flat, answer), ends = ends_of_the_picture()
    answer.output[0] = "deviation"
    return [*nodes, flat, answer], [*constants, *ends]


def write(
    folder: Path,
    policy: Parts,
    manifest: str = MANIFEST,
    inputs: Sequence[tuple[str, Sequence[int | str]]] = (("image", IMAGE), ("state", STATE)),
    output: tuple[str, Sequence[int | str]] = ("action", (1, 2)),
    more_outputs: Sequence[str] = (),
    kind: int = TensorProto.FLOAT,
    name: str = "policy",
    edit: Callable[[str], str] = str,
) -> Path:
    """The model's file, with its manifest beside it."""
    nodes, constants = policy
    taken = [helper.make_tensor_value_info(one, kind, shape) for one, shape in inputs]
    outputs = [output, *((one, (1, 2)) for one in more_outputs)]
    given = [helper.make_tensor_value_info(one, TensorProto.FLOAT, shape) for one, shape in outputs]
    graph = helper.make_graph(nodes, "policy", taken, given, constants)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    path = folder / f"{name}.onnx"
    path.write_bytes(model.SerializeToString())
    path.with_suffix(".toml").write_text(edit(manifest))
    return path
