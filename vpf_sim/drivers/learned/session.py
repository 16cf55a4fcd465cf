"""A model in onnxruntime, checked against its manifest."""

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

from vpf_sim.drivers.learned.manifest import Manifest, file_of
from vpf_sim.drivers.learned.random_operators import random_operators
from vpf_sim.errors import InputError
from vpf_sim.types import Floats, Singles

INSTALL = "expected onnxruntime, which is not installed: pip install 'vpf_sim[onnx]'"
FLOAT = "tensor(float)"
ACTION = (1, 2)
SURE = "expected a model that gives equal actions for equal inputs, such as the mean of a stochastic policy"
MOST_LISTED = 3  # operators in a message
FATAL = 4  # the least talkative of onnxruntime's levels: faults are raised anyway


class Session:
    """A model that maps a policy's inputs to its action, on one thread: equal inputs give equal actions."""

    def __init__(self, model: Path, manifest: Manifest) -> None:
        self._output = manifest.output
        content = _content(model)
        self._session = _opened(model, content)
        faults = [*_faults(self._session, manifest, model)]
        if operators := random_operators(content, manifest.output):
            faults.append(f"{model}: {SURE}, got the random operator {', '.join(operators[:MOST_LISTED])}")
        if faults:
            raise InputError("\n".join(faults))

    def action(self, inputs: dict[str, Singles]) -> Floats:
        """(2,) throttle and steering."""
        action: Floats = self._session.run([self._output], inputs)[0][0].astype(float)
        return action


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
    if manifest.output not in outputs:
        yield f"{toml}: output: expected an output of {model.name}, {_named(outputs)}, got '{manifest.output}'"
        return
    action = outputs[manifest.output]
    if action.type != FLOAT or not _fits(action.shape, ACTION):
        wanted = f"{FLOAT} of shape {_shape(ACTION)}, throttle and steering"
        yield f"{model}: output '{action.name}': expected {wanted}, got {action.type} of {_shape(action.shape)}"


def _fits(actual: Sequence[Any], expected: Sequence[int]) -> bool:
    """Whether shapes agree; a dimension that the model leaves open fits any."""
    pairs = zip(actual, expected, strict=False)
    return len(actual) == len(expected) and all(not isinstance(has, int) or has == want for has, want in pairs)


def _shape(shape: Sequence[Any]) -> str:
    return f"({', '.join(str(size) for size in shape)})"


def _named(names: Iterable[str]) -> str:
    return " or ".join(f"'{name}'" for name in sorted(names))
