"""The manifest of a learned policy: what its model takes in, how often it decides, and how it was trained."""

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from vpf_sim import configuration
from vpf_sim.configuration import setting, settings

Ago = Annotated[int, Field(ge=0, le=1000)]
BLOCKS = (3, 4)  # rows and columns of a picture whose statistics are kept
STATISTICS = 2 * BLOCKS[0] * BLOCKS[1]  # brightness and texture of each block
StateValue = Literal["speed", "yaw_rate", "goal_forward", "goal_right", "throttle", "steering"]


@settings
class Crop:
    """The part of the camera's picture that the policy gets, by shares of width and height."""

    left_share: float = setting(
        "Left side of the crop, as a share of the picture's width.", default=0.0, ge=0.0, lt=1.0
    )
    top_share: float = setting(
        "Upper side of the crop, as a share of the picture's height.", default=0.0, ge=0.0, lt=1.0
    )
    right_share: float = setting(
        "Right side of the crop, as a share of the picture's width.", default=1.0, gt=0.0, le=1.0
    )
    bottom_share: float = setting(
        "Lower side of the crop, as a share of the picture's height.", default=1.0, gt=0.0, le=1.0
    )

    def __post_init__(self) -> None:
        for low, high in (("left_share", "right_share"), ("top_share", "bottom_share")):
            if getattr(self, low) >= getattr(self, high):
                raise ValueError(f"{low}: expected < {high}, {getattr(self, high):g}, got {getattr(self, low):g}")


@settings
class PictureInput:
    """The picture, float32 (1, channels x frames, height, width): value = (grey level - mean) / deviation."""

    width_px: int = setting("Width of the picture that the model gets.", gt=0, le=4096)
    height_px: int = setting("Height of the picture that the model gets.", gt=0, le=4096)
    input: str = setting("Name of the model's input for the picture.", default="image")
    colour: Literal["grey", "rgb"] = setting("Whether the picture has one channel or three.", default="grey")
    frames_ago: tuple[Ago, ...] = setting(
        "Frames that are stacked along the channels, in order, by the number of decisions since.",
        default=(0,),
        min_length=1,
    )
    mean: float = setting("Grey level that is subtracted.", default=0.0)
    deviation: float = setting("Grey levels that count as 1.", default=255.0, gt=0.0)
    crop: Crop = setting("Part of the camera's picture that is used.", default_factory=Crop)

    @property
    def channels(self) -> int:
        """Of the stack."""
        return len(self.frames_ago) * (1 if self.colour == "grey" else 3)

    @property
    def shape(self) -> tuple[int, ...]:
        """Of the model's input."""
        return 1, self.channels, self.height_px, self.width_px


@settings
class StateInput:
    """The state vector, float32 (1, number of values), each in [-1, 1] as in vpf_sim/FourLanePixels-v0."""

    values: tuple[StateValue, ...] = setting("Values of the state vector, in order.", min_length=1)
    input: str = setting("Name of the model's input for the state.", default="state")

    @property
    def shape(self) -> tuple[int, ...]:
        """Of the model's input."""
        return 1, len(self.values)


@settings
class Uncertainty:
    """How the policy says that it is unsure."""

    limit: float = setting("Standard deviation of the steering, -1 to 1, above which the policy is unsure.", gt=0.0)
    output: str = setting(
        "Name of the model's output, (1, 2): standard deviations of throttle and steering.", default="deviation"
    )


@settings
class LearnedFrom:
    """What the inputs of the training were like, so that a replay can say where others are unlike them."""

    speed_mps: tuple[float, float] = setting("Slowest and fastest speed of the training.")
    mean: tuple[float, ...] = setting(
        "Means of the picture's statistics: grey levels of 3 x 4 blocks, then logarithms of their texture."
    )
    deviation: tuple[Annotated[float, Field(gt=0.0)], ...] = setting("Standard deviations of these statistics.")
    limit: float = setting("Distance from the means, in deviations, above which a picture is unlike.", gt=0.0)

    def __post_init__(self) -> None:
        slowest, fastest = self.speed_mps
        if slowest > fastest:
            raise ValueError(f"speed_mps: expected the slower speed first, got {slowest:g}, {fastest:g}")
        for name in ("mean", "deviation"):
            if len(getattr(self, name)) != STATISTICS:
                raise ValueError(f"{name}: expected {STATISTICS} numbers, got {len(getattr(self, name))}")


@settings
class Training:
    """How the policy was trained, for the record."""

    command: str = setting("Command that trained the policy.", default="")
    commit: str = setting("Commit of the sources that trained the policy.", default="")
    expert: str = setting("Drivers that the policy was cloned from.", default="")
    curve: tuple[float, ...] = setting("Loss after each epoch of the training.", default=())
    scenarios: tuple[str, ...] = setting("Scenarios that the policy was trained on.", default=())
    weathers: tuple[str, ...] = setting("Weathers that the policy was trained in.", default=())
    seeds: str = setting('Seeds of the training drives as "A:B", without B.', default="")
    frames: int = setting("Number of frames that the policy was fitted to.", default=0, ge=0)
    driven_h: float = setting("Hours of driving that the training frames show.", default=0.0, ge=0.0)
    wall_h: float = setting("Hours that collection and fitting took.", default=0.0, ge=0.0)


@settings
class Manifest:
    """`model.toml` beside `model.onnx`; the model gets a picture, a state vector, or both."""

    schema: Literal[1] = setting("Version of the format of this file.")
    rate_hz: float = setting("Decisions a second; a command is held in between.", gt=0.0, le=1000.0)
    summary: str = setting("What the policy does, in one line for listings.", default="")
    privileged: Literal["none"] = setting(
        "Privilege of the policy: it gets nothing beyond camera, odometry and goal.", default="none"
    )
    output: str = setting("Name of the model's output, (1, 2): throttle and steering.", default="action")
    image: PictureInput | None = setting("Picture that the model gets; without it no frames are drawn.", default=None)
    state: StateInput | None = setting("State vector that the model gets.", default=None)
    uncertainty: Uncertainty | None = setting("How the policy says that it is unsure.", default=None)
    learned_from: LearnedFrom | None = setting("What the inputs of the training were like.", default=None)
    training: Training | None = setting("How the policy was trained.", default=None)

    def __post_init__(self) -> None:
        if self.image is None and self.state is None:
            raise ValueError("expected at least one of [image] and [state]")
        if self.image is not None and self.state is not None and self.image.input == self.state.input:
            raise ValueError(f"state.input: expected another name than image.input, got '{self.state.input}'")
        if self.uncertainty is not None and self.uncertainty.output == self.output:
            raise ValueError(f"uncertainty.output: expected another name than output, got '{self.output}'")

    @property
    def outputs(self) -> dict[str, str]:
        """Names of the outputs that are used, by their key in this file."""
        deviation = {} if self.uncertainty is None else {"uncertainty.output": self.uncertainty.output}
        return {"output": self.output, **deviation}


def file_of(model: Path) -> Path:
    """The manifest's file of a model."""
    return model.with_suffix(".toml")


def load(model: Path) -> Manifest:
    """The manifest beside a model; InputError with a line for each fault."""
    path = file_of(model)
    table = configuration.read_file(path, "policy manifest")
    return configuration.build(Manifest, table, str(path))
