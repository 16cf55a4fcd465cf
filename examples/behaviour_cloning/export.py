"""Writing the network as an ONNX model with its manifest."""

import subprocess
from dataclasses import asdict
from pathlib import Path
from typing import Any

import torch
from torch import nn

from vpf_sim.drivers.learned.manifest import Manifest, file_of
from vpf_sim.files import write_text


def export(network: nn.Module, manifest: Manifest, model: Path) -> None:
    """Write `model` and the manifest beside it."""
    assert manifest.image is not None
    assert manifest.state is not None
    inputs = (torch.zeros(manifest.image.shape), torch.zeros(manifest.state.shape))
    network.eval()
    torch.onnx.export(
        network,
        inputs,
        str(model),
        input_names=[manifest.image.input, manifest.state.input],
        output_names=[*manifest.outputs.values()],
        opset_version=17,
        dynamo=False,
    )
    write_text(file_of(model), toml(asdict(manifest)))


def commit() -> str:
    """The commit of the checkout that this file lies in; "" elsewhere."""
    command = ["git", "-C", str(Path(__file__).parent), "rev-parse", "HEAD"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return done.stdout.strip()


def toml(table: dict[str, Any], path: str = "") -> str:
    """A table as TOML, its own values first; None is left out."""
    plain = [f"{key} = {_value(value)}" for key, value in table.items() if not isinstance(value, dict | None)]
    sections = [
        f"\n[{path}{key}]\n{toml(value, f'{path}{key}.')}" for key, value in table.items() if isinstance(value, dict)
    ]
    return "".join(f"{line}\n" for line in plain) + "".join(sections)


def _value(value: Any) -> str:
    if isinstance(value, tuple | list):
        return f"[{', '.join(map(_value, value))}]"
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    return str(value)
