"""Policies that draw random numbers are refused, by the names of their operators."""

from pathlib import Path
from typing import Any

import numpy as np
import onnx
import policies
import pytest
from onnx import TensorProto, helper, numpy_helper

from vpf_sim.drivers.learned.driver import OnnxDriver
from vpf_sim.drivers.learned.session import random_operators
from vpf_sim.errors import InputError

FLOAT, SHAPE = TensorProto.FLOAT, (1, 2)
node = helper.make_node
ADD = node("Add", ["state", "noise"], ["action"])
MEAN = node("Identity", ["state"], ["action"])


def boolean(name: str, value: bool) -> onnx.TensorProto:
    return numpy_helper.from_array(np.array(value), name)


def branches(inner: onnx.NodeProto) -> list[onnx.NodeProto]:
    """An If whose first branch has a node."""
    output = helper.make_tensor_value_info("noise", FLOAT, SHAPE)
    then = helper.make_graph([inner], "then", [], [output])
    other = helper.make_graph([node("Identity", ["state"], ["noise"])], "else", [], [output])
    return [node("If", ["yes"], ["noise"], then_branch=then, else_branch=other), ADD]


RANDOM: dict[str, tuple[list[onnx.NodeProto], list[onnx.TensorProto]]] = {
    "RandomNormal": ([node("RandomNormal", [], ["noise"], shape=SHAPE), ADD], []),
    "RandomNormalLike": ([node("RandomNormalLike", ["state"], ["noise"], scale=0.05), ADD], []),
    "RandomUniform": ([node("RandomUniform", [], ["noise"], shape=SHAPE, seed=1.0), ADD], []),
    "RandomUniformLike": ([node("RandomUniformLike", ["state"], ["noise"]), ADD], []),
    "Bernoulli": ([node("Sigmoid", ["state"], ["p"]), node("Bernoulli", ["p"], ["noise"]), ADD], []),
    "Multinomial": (
        [
            node("Multinomial", ["state"], ["chosen"], name="p", sample_size=2),
            node("Cast", ["chosen"], ["noise"], to=FLOAT),
            ADD,
        ],
        [],
    ),
    "Dropout": (
        [node("Dropout", ["state", "half", "on"], ["noise"]), ADD],
        [numpy_helper.from_array(np.float32(0.5), "half"), boolean("on", True)],
    ),
    "RandomNormalLike in a branch": (branches(node("RandomNormalLike", ["state"], ["noise"])), [boolean("yes", True)]),
}
CERTAIN: dict[str, tuple[list[onnx.NodeProto], list[onnx.TensorProto]]] = {
    "no operator": ([MEAN], []),
    "for another output": ([node("RandomNormalLike", ["state"], ["noise"]), MEAN], []),
    "dropout that does nothing": ([node("Dropout", ["state"], ["noise"]), ADD], []),
    "dropout switched off": ([node("Dropout", ["state", "", "off"], ["noise"]), ADD], [boolean("off", False)]),
    "dropout switched off by a node": (
        [
            node("Constant", [], ["off"], value=boolean("value", False)),
            node("Dropout", ["state", "", "off"], ["noise"]),
            ADD,
        ],
        [],
    ),
    "a branch that is certain": (branches(node("Neg", ["state"], ["noise"])), [boolean("yes", True)]),
}
MANIFEST = 'schema = 1\nrate_hz = 20.0\n[state]\nvalues = ["throttle", "steering"]\n'


def written(folder: Path, policy: Any) -> Path:
    return policies.write(folder, policy, MANIFEST, inputs=[("state", SHAPE)])


@pytest.mark.parametrize("name", RANDOM)
def test_a_model_with_a_random_operator_is_refused(name: str, tmp_path: Path) -> None:
    path, kind = written(tmp_path, RANDOM[name]), name.partition(" ")[0]
    with pytest.raises(InputError) as caught:
        OnnxDriver(path)
    assert str(caught.value).startswith(f"{path}: expected a model that gives equal actions for equal inputs")
    assert str(caught.value).endswith(f"got the random operator {kind} '{'p' if kind == 'Multinomial' else 'noise'}'")


@pytest.mark.parametrize("name", CERTAIN)
def test_a_model_that_is_certain_is_taken(name: str, tmp_path: Path) -> None:
    path = written(tmp_path, CERTAIN[name])
    assert random_operators(path.read_bytes(), "action") == []
    assert OnnxDriver(path).uses_images is False


def test_random_operator_in_a_function_of_the_model_is_found() -> None:
    """As exporters write the functions of their own libraries: one calls another."""
    opset = [helper.make_opsetid("", 17), helper.make_opsetid("own", 1)]
    inner = helper.make_function(
        "own", "draw", ["x"], ["y"], [node("RandomUniformLike", ["x"], ["y"], name="draws")], opset
    )
    outer = helper.make_function("own", "jitter", ["x"], ["y"], [node("draw", ["x"], ["y"], domain="own")], opset)
    graph = helper.make_graph(
        [node("jitter", ["state"], ["noise"], domain="own"), ADD],
        "policy",
        [helper.make_tensor_value_info("state", FLOAT, SHAPE)],
        [helper.make_tensor_value_info("action", FLOAT, SHAPE)],
    )
    model = helper.make_model(graph, opset_imports=opset, functions=[inner, outer], ir_version=8)
    assert random_operators(model.SerializeToString(), "action") == ["RandomUniformLike 'draws'"]


def test_several_operators_are_named_in_their_order() -> None:
    nodes = [
        node("RandomNormalLike", ["state"], ["a"], name="first"),
        node("RandomUniformLike", ["a"], ["b"], name="second"),
        node("Add", ["a", "b"], ["action"]),
    ]
    graph = helper.make_graph(nodes, "policy", [helper.make_tensor_value_info("state", FLOAT, SHAPE)], [])
    found = random_operators(helper.make_model(graph).SerializeToString(), "action")
    assert found == ["RandomNormalLike 'first'", "RandomUniformLike 'second'"]
