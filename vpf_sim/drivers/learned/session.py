"""A model in onnxruntime, checked against its manifest."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from vpf_sim.drivers.learned.manifest import Manifest, file_of
from vpf_sim.errors import InputError
from vpf_sim.types import Floats, Singles

INSTALL = "expected onnxruntime, which is not installed: pip install 'vpf_sim[onnx]'"
FLOAT = "tensor(float)"
ACTION = (1, 2)
FATAL = 4  # the least talkative of onnxruntime's levels: faults are raised anyway


class Session:
    """A model that maps a policy's inputs to its action, on one thread: equal inputs give equal actions."""

    def __init__(self, model: Path, manifest: Manifest) -> None:
        self._output = manifest.output
        self._session = _opened(model)
        faults = [*_faults(self._session, manifest)]
        if faults:
            raise InputError("\n".join(f"{file_of(model)}: {fault} in {model.name}" for fault in faults))

    def action(self, inputs: dict[str, Singles]) -> Floats:
        """(2,) throttle and steering."""
        action: Floats = self._session.run([self._output], inputs)[0][0].astype(float)
        return action


def _opened(model: Path) -> Any:
    """The session; InputError without onnxruntime, without the file, or where the file is no model."""
    try:
        import onnxruntime
    except ImportError:
        raise InputError(f"{model}: {INSTALL}") from None
    try:
        content = model.read_bytes()
    except OSError as error:
        raise InputError(f"{model}: expected a readable ONNX model, got: {error.strerror}") from None
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.log_severity_level = FATAL
    try:
        return onnxruntime.InferenceSession(content, options, providers=["CPUExecutionProvider"])
    except Exception as error:  # onnxruntime has its own exceptions, which are not public
        reason = " ".join(str(error).split())[:200]
        raise InputError(f"{model}: expected an ONNX model in one file, got: {reason}") from None


def _faults(session: Any, manifest: Manifest) -> Iterator[str]:
    """What of a model is not as its manifest says: key, expected, actual."""
    expected = {f"{key}.input": given for key in ("image", "state") if (given := getattr(manifest, key)) is not None}
    actual = {one.name: one for one in session.get_inputs()}
    for key, given in expected.items():
        if given.input not in actual:
            yield f"{key}: expected an input of the model, {_named(actual)}, got '{given.input}'"
        else:
            yield from _tensor_faults(key.removesuffix(".input"), actual[given.input], given.shape)
    unused = sorted(actual.keys() - {given.input for given in expected.values()})
    if unused and len(actual) > len(expected):
        yield f"inputs: expected {len(expected)}, got more: {_named(unused)}"
    outputs = {one.name: one for one in session.get_outputs()}
    if manifest.output not in outputs:
        yield f"output: expected an output of the model, {_named(outputs)}, got '{manifest.output}'"
    else:
        yield from _tensor_faults("output", outputs[manifest.output], ACTION)


def _tensor_faults(key: str, tensor: Any, shape: tuple[int, ...]) -> Iterator[str]:
    """Type and shape; a dimension that the model leaves open fits any."""
    if tensor.type != FLOAT:
        yield f"{key}: expected '{tensor.name}' as {FLOAT}, got {tensor.type}"
    fits = len(tensor.shape) == len(shape) and all(
        not isinstance(have, int) or have == want for have, want in zip(tensor.shape, shape, strict=True)
    )
    if not fits:
        yield f"{key}: expected '{tensor.name}' of shape {_shape(shape)}, got {_shape(tensor.shape)}"


def _shape(shape: Sequence[Any]) -> str:
    return f"({', '.join(str(size) for size in shape)})"


def _named(names: Any) -> str:
    return " or ".join(f"'{name}'" for name in names)
