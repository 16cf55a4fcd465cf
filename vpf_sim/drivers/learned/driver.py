"""The driver that runs an ONNX policy."""

from collections import deque
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from math import nan
from pathlib import Path

import cv2
import numpy as np

from vpf_sim.driver_interface import Command, Driver, DriverSetup, Observation, Privilege
from vpf_sim.drivers.learned import manifest as manifests
from vpf_sim.drivers.learned.familiarity import Familiarity
from vpf_sim.drivers.learned.manifest import Manifest, PictureInput, StateInput
from vpf_sim.drivers.learned.session import Session
from vpf_sim.errors import InputError
from vpf_sim.perception.egomotion.flow import grey
from vpf_sim.perception.schedule import Schedule
from vpf_sim.policy_state import STATE, policy_state
from vpf_sim.types import Floats, Image, Singles


def shrink(image: Image, config: PictureInput) -> Image:
    """(channels of a frame, height, width) uint8: a frame cropped, in grey or RGB, and averaged to the size."""
    height, width = image.shape[:2]
    crop = config.crop
    rows = slice(round(crop.top_share * height), round(crop.bottom_share * height))
    columns = slice(round(crop.left_share * width), round(crop.right_share * width))
    part = np.ascontiguousarray(image[rows, columns])
    if config.colour == "grey":
        part = grey(part)
    small = np.asarray(cv2.resize(part, (config.width_px, config.height_px), interpolation=cv2.INTER_AREA), np.uint8)
    return small[None] if config.colour == "grey" else np.ascontiguousarray(small.transpose(2, 0, 1))


class PolicyInputs:
    """Collects the inputs of one episode."""

    def __init__(self, manifest: Manifest) -> None:
        self._manifest = manifest
        oldest = max(manifest.image.frames_ago) if manifest.image else 0
        self._pictures: deque[Image] = deque(maxlen=oldest + 1)  # newest first

    def at(self, observation: Observation, action: Floats) -> dict[str, Singles] | None:
        """The model's inputs by name, at a decision after `action`; None where no frame has arrived yet."""
        inputs: dict[str, Singles] = {}
        if self._manifest.image is not None:
            picture = self._picture(observation.image, self._manifest.image)
            if picture is None:
                return None
            inputs[self._manifest.image.input] = picture
        if self._manifest.state is not None:
            inputs[self._manifest.state.input] = state_vector(observation, action, self._manifest.state)
        return inputs

    @property
    def newest(self) -> Image | None:
        """(channels of a frame, height, width) the newest picture; None without one."""
        return self._pictures[0] if self._pictures else None

    def _picture(self, image: Image, config: PictureInput) -> Singles | None:
        """The stack with this frame; for frames before the first, the first stands in."""
        if not image.size:
            return None
        self._pictures.appendleft(shrink(image, config))
        oldest = len(self._pictures) - 1
        stack = np.concatenate([self._pictures[min(ago, oldest)] for ago in config.frames_ago])
        return normalised(stack[None], config)


def normalised(pictures: Image, config: PictureInput) -> Singles:
    """Pictures as the model gets them."""
    return (pictures.astype(np.float32) - np.float32(config.mean)) / np.float32(config.deviation)


def state_vector(observation: Observation, action: Floats, config: StateInput) -> Singles:
    """(1, values) the chosen values of the state."""
    values = policy_state(
        observation.pose, observation.speed_mps, observation.yaw_rate_radps, observation.goal_m, action
    )
    return values[[STATE.index(name) for name in config.values]][None]


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
        known = self.manifest.learned_from
        self._familiarity = None if known is None else Familiarity(known)
        self._schedule = Schedule(1.0 / self.manifest.rate_hz, setup.rate_hz)
        self._action: Floats = np.zeros(2)
        self._uncertainty = nan

    @property
    def needs_next_frame(self) -> bool:
        """Whether it decides at the next step."""
        return self._schedule.is_due

    def act(self, observation: Observation) -> Command:
        if self._schedule.step():
            inputs = self._inputs.at(observation, self._action)
            if inputs is not None:
                action, *deviation = self._session.run(inputs)
                self._action = np.clip(action, -1.0, 1.0)
                if self.manifest.uncertainty is not None:
                    self._uncertainty = float(deviation[0][1]) / self.manifest.uncertainty.limit
                if self._familiarity is not None:
                    self._familiarity.add(self._inputs.newest, observation.speed_mps)
        return Command(*self._action.tolist())

    def uncertainty(self) -> float:
        """The steering's standard deviation by its limit; nan before the first decision, or if the model has none."""
        return self._uncertainty

    def unlike_training(self) -> str:
        """What was unlike the training in most decisions, in one line; empty if nothing, or if nothing is known."""
        return "" if self._familiarity is None else self._familiarity.remark()


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
