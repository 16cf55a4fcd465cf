"""The driver that runs an ONNX policy."""

from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np

from vpf_sim.drivers.learned import manifest as manifests
from vpf_sim.drivers.learned.inputs import PolicyInputs
from vpf_sim.drivers.learned.manifest import Manifest
from vpf_sim.drivers.learned.session import Session
from vpf_sim.errors import InputError
from vpf_sim.perception.schedule import Schedule
from vpf_sim.types import Command, Driver, DriverSetup, Floats, Observation, Privilege


class OnnxDriver(Driver):
    """Asks a policy at its rate, and holds the command in between."""

    def __init__(self, model: str | Path) -> None:
        self.model_path = Path(model)
        self.manifest: Manifest = manifests.load(self.model_path)
        self._session = Session(self.model_path, self.manifest)
        self.privileged: Privilege = self.manifest.privileged
        self.uses_images = self.manifest.image is not None

    def reset(self, setup: DriverSetup) -> None:
        self._inputs = PolicyInputs(self.manifest)
        self._schedule = Schedule(1.0 / self.manifest.rate_hz, setup.rate_hz)
        self._action: Floats = np.zeros(2)

    @property
    def needs_next_frame(self) -> bool:
        """Whether it decides at the next step."""
        return self._schedule.is_due

    def act(self, observation: Observation) -> Command:
        if self._schedule.step():
            inputs = self._inputs.at(observation, self._action)
            if inputs is not None:
                self._action = np.clip(self._session.action(inputs), -1.0, 1.0)
        return Command(*self._action.tolist())


def code(model: Path) -> str:
    """SHA-256 of what a policy's commands depend on: model, manifest, and the version of onnxruntime."""
    try:
        runtime = version("onnxruntime")
    except PackageNotFoundError:
        runtime = "none"
    digest = sha256(runtime.encode())
    for path in (model, manifests.file_of(model)):
        try:
            digest.update(sha256(path.read_bytes()).digest())
        except OSError as error:
            raise InputError(f"{path}: expected a readable file of a policy, got: {error.strerror}") from None
    return digest.hexdigest()
