"""The records that flow between the stages, in the order in which they flow.

    frame -> flow -> focus of expansion, time to contact, obstacles, road edges -> fields -> reference -> command

Axes: world and vehicle X forward, Y right, yaw clockwise (growing when turning right), SI units. Image x right, y down,
in OpenCV's convention: the centre of the first pixel is (0, 0). The pose of the vehicle is its centre of mass, which is
the centre of its body. N is a number of image points, K a number of obstacles.
"""

from dataclasses import dataclass, field, fields, replace
from importlib import import_module
from math import inf, radians, tan
from typing import TYPE_CHECKING, Any, ClassVar, Generic, NamedTuple, Protocol, Self, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from vpf_sim.errors import InputError

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Reals = NDArray[np.floating[Any]]  # of single or double precision
Bools = NDArray[np.bool_]
Integers = NDArray[np.int64]
Image = NDArray[np.uint8]  # (H, W, 3) RGB or (H, W) grey

FROM_SIZE = cast(float, None)  # in the place of what follows from the size of a picture


@dataclass(frozen=True, slots=True)
class Camera:
    """A pinhole camera on the vehicle, looking forward; k1, k2 are the radial distortion of OpenCV's model.

    What is not given of the lens follows from the size: 90 deg across, square pixels, the axis in the middle.
    """

    width_px: int = 640
    height_px: int = 480
    fx_px: float = FROM_SIZE
    fy_px: float = FROM_SIZE
    cx_px: float = FROM_SIZE
    cy_px: float = FROM_SIZE
    height_m: float = 1.4  #: above the road
    forward_m: float = 0.8  #: ahead of the pose
    pitch_rad: float = 0.0  #: + looks down
    k1: float = 0.0
    k2: float = 0.0

    def __post_init__(self) -> None:
        focal_px = next((given for given in (self.fx_px, self.fy_px) if given is not FROM_SIZE), None)
        if focal_px is None:
            focal_px = 0.5 * self.width_px
        follows = {
            "fx_px": focal_px,
            "fy_px": focal_px,
            "cx_px": 0.5 * (self.width_px - 1),
            "cy_px": 0.5 * (self.height_px - 1),
        }
        for key, value in follows.items():
            if getattr(self, key) is FROM_SIZE:
                object.__setattr__(self, key, value)

    @classmethod
    def of(cls, width_px: int, height_px: int, fov_deg: float = 90.0, **mounting: float) -> Self:
        """The camera with a size and a horizontal field of view; `mounting` are other fields, such as `height_m`."""
        if not 1.0 <= fov_deg <= 170.0:
            raise InputError(f"camera: fov_deg: expected 1 to 170, got {fov_deg}")
        focal_px = round(0.5 * width_px / tan(0.5 * radians(fov_deg)), 9)
        return cls(width_px, height_px, focal_px, focal_px, **mounting)


@dataclass(frozen=True, slots=True)
class VehicleModel:
    """The ego car as its driver knows it: kinematic bicycle, limits of the actuators."""

    l_f_m: float = 1.35  # centre of mass to front axle
    l_r_m: float = 1.35  # centre of mass to rear axle
    width_m: float = 1.9
    length_m: float = 4.5
    steering_limit_rad: float = radians(40.0)
    steering_rate_limit_radps: float = 1.0
    full_throttle_mps2: float = 3.0
    full_brake_mps2: float = 6.0

    def __post_init__(self) -> None:
        for item in fields(self):
            if not 0.0 < getattr(self, item.name) < inf:
                raise ValueError(f"{item.name}: expected a finite number > 0, got {getattr(self, item.name)}")
        if not self.steering_limit_rad < radians(90.0):
            raise ValueError(f"steering_limit_rad: expected < pi / 2, got {self.steering_limit_rad}")

    @property
    def wheelbase_m(self) -> float:
        return self.l_f_m + self.l_r_m

    def full_mps2(self, acceleration: float) -> float:
        """m/s^2, what full throttle gives (an acceleration or throttle > 0), or the full brake takes."""
        return self.full_throttle_mps2 if acceleration > 0.0 else self.full_brake_mps2


@dataclass(frozen=True, slots=True)
class Flow:
    """Sparse optical flow: N image points, each followed frame by frame over a window of `gap_s`.

    A pose row is (x, y, yaw): m, m, rad.
    """

    points_px: Floats  # (N, 2) now
    displacement_px: Floats  # (N, 2) from the start of the point's window to now
    gap_s: Floats  # (N,) length of the window
    past_pose: Floats  # (N, 3) of the vehicle at the start of the window
    pose: Floats  # (3,) of the vehicle now
    identity: NDArray[np.int64]  # (N,) stays with a point for as long as it is followed
    first_px: Floats  # (N, 2) where the point was first seen
    first_pose: Floats  # (N, 3) of the vehicle then
    age_frames: NDArray[np.int64]  # (N,) frames since then
    structure: Floats  # (N, 2, 2) mean structure tensor of the window about the point, grey levels^2 / px^2
    on_glass: Bools = field(default_factory=lambda: np.empty(0, np.bool_))  # (N,) on the glass; left out, none is
    occluded: NDArray[np.int64] = field(
        default_factory=lambda: np.empty(0, np.int64)
    )  # identities of others, unseen now

    def __post_init__(self) -> None:
        if len(self.on_glass) != len(self.points_px):
            object.__setattr__(self, "on_glass", np.zeros(len(self.points_px), np.bool_))

    def __len__(self) -> int:
        return len(self.points_px)

    def select(self, rows: Integers) -> "Flow":
        """Some of the points, (n,) by their rows."""
        points = [name for name in Flow.__slots__ if name not in ("pose", "occluded")]
        return replace(self, **{name: getattr(self, name)[rows] for name in points})


@dataclass(frozen=True, slots=True)
class Expansion:
    """The focus of expansion: the image of the direction in which the camera's centre moves."""

    x_px: float
    y_px: float
    covariance_px2: Floats  # (2, 2)
    inliers: Bools  # (N,) points of the flow that agree
    confidence: float  # 0 (not to be used) .. 1


@dataclass(frozen=True, slots=True)
class ObstacleMap:
    """The paper's O_t: which points stand out, the same as a coarse binary plane, and its smoothed gradient."""

    on_obstacle: Bools  # (N,)
    plane: Floats  # (h, w) 0 or 1, the image reduced by `reduction`
    gradient: Floats  # (2, h, w) of the smoothed plane, per image pixel: (x, y)
    reduction: int


Metres = TypeVar("Metres", float, Floats)


class LateralExtent(Generic[Metres]):
    """An obstacle, or K obstacles, with a left and a right side."""

    __slots__ = ()
    left_m: Metres
    right_m: Metres

    @property
    def middle_m(self) -> Metres:
        """Lateral position of the middle, () or (K,)."""
        return 0.5 * (self.left_m + self.right_m)

    @property
    def width_m(self) -> Metres:
        """Across the road, () or (K,)."""
        return self.right_m - self.left_m


class Rows:
    """A dataclass that has a row for each of K things in every field."""

    __slots__ = ()
    __dataclass_fields__: ClassVar[dict[str, Any]]

    def select(self, rows: Integers | Bools) -> Self:
        """Some of them."""
        return type(self)(*(getattr(self, field.name)[rows] for field in fields(self)))

    def concatenate(self, others: Self) -> Self:
        """These, and the others after them."""
        pairs = ((getattr(self, field.name), getattr(others, field.name)) for field in fields(self))
        return type(self)(*(np.concatenate(pair) for pair in pairs))


class LateralExtents(LateralExtent[Floats], Rows):
    """K obstacles."""

    __slots__ = ()


@dataclass(frozen=True, slots=True)
class Obstacles(LateralExtents):
    """K obstacles on the road as perceived, in vehicle axes: nearest face, side edges, time to contact."""

    forward_m: Floats  # (K,) nearest face, from the pose
    left_m: Floats  # (K,) lateral position of the left side, + is right
    right_m: Floats  # (K,) of the right side
    sigma_m: Floats  # (K,) standard deviation of forward_m
    ttc_s: Floats  # (K,) inf where the gap does not close, and before the scene has tracks of them
    identity: NDArray[np.int64]  # (K,) negative where it moves
    speed_mps: Floats = field(default_factory=lambda: np.empty(0))  # (K,) along the road; left out, all stand
    existence: Floats = field(default_factory=lambda: np.empty(0))  # (K,) probability; nan, as left out: not stated

    def __post_init__(self) -> None:
        for name, left_out in (("speed_mps", 0.0), ("existence", np.nan)):
            if len(getattr(self, name)) != len(self.forward_m):
                object.__setattr__(self, name, np.full(len(self.forward_m), left_out))

    def __len__(self) -> int:
        return len(self.forward_m)


@dataclass(frozen=True, slots=True)
class RoadEdges:
    """The carriageway about the vehicle, seen by the camera; distances across the road, at the pose.

    On a road of two directions it has the lanes of ours alone, up to the solid line at `left_m`. `right_m` > 0 and
    `left_m` < 0 while the pose is on it. The own lane is that in which the vehicle was when it first saw the road; in
    the paper's terms, y = -lane_m, y_r = right_m - lane_m.
    """

    left_m: float
    right_m: float
    heading_rad: float  # direction of the road minus yaw, at the pose
    curvature_per_m: float  # + bends right
    sigma_m: float  # standard deviation of the lateral position
    confidence: float  # 0 (prior only) .. 1
    lane_m: float  # middle of the own lane, + is right of the pose
    lane_width_m: float
    lane_confidence: float = 0.0  # of the own lane's lines, whichever lines are the edges: 0 .. 1
    oncoming_m: float = 0.0  # width of the lanes of oncoming traffic, left of left_m


class PointFeatures(Protocol):
    """What the paper's fields ask of the points of the flow."""

    @property
    def obstacle_map(self) -> ObstacleMap:
        """The paper's O_t."""
        ...

    @property
    def ttc_s(self) -> Floats:
        """(N,) time to contact of each point; inf where unknown."""
        ...


@dataclass(frozen=True, slots=True)
class KnownFeatures:
    """Point features with given values."""

    obstacle_map: ObstacleMap
    ttc_s: Floats


class LowObstacleRange(NamedTuple):
    """m ahead of the pose up to which a low obstacle would be tentative: at this moment, and with a good view."""

    now_m: float = inf
    best_m: float = inf


UNLIMITED = LowObstacleRange()


@dataclass(frozen=True, slots=True)
class Perception:
    """What a driver perceives at one step; flow, expansion and features are of the last frame that was processed."""

    flow: Flow
    expansion: Expansion
    features: PointFeatures
    obstacles: Obstacles
    road: RoadEdges
    pose: Floats  # (3,) x m, y m, yaw rad of the vehicle
    low_range_m: LowObstacleRange = UNLIMITED


@dataclass(frozen=True, slots=True)
class Force:
    """Forces of fields at the vehicle, in vehicle axes: (2,) each, X forward, Y right."""

    target: Floats
    obstacle: Floats
    road: Floats
    total: Floats


NO_FORCE = Force(*np.zeros((4, 2)))


@dataclass(frozen=True, slots=True)
class Reference:
    """What the controller tracks."""

    heading_rad: float  # in the world
    speed_mps: float
    heading_rate_radps: float | None = None  # None: the controller differentiates the heading itself
    acceleration_mps2: float = 0.0  # along the motion that is planned


@dataclass(frozen=True, slots=True)
class PlanDetails:
    """Base of the records in which a planner hands on more than its reference."""


@dataclass(frozen=True, slots=True)
class Plan:
    """One pass of the planner, for the controller, the overlay and the scores."""

    perception: Perception | None  # None of a driver that is given the world
    force: Force
    reference: Reference
    extra: PlanDetails | None = None  # PaperPlan or MotionPlan; None of another planner
    reaching: bool | None = None  # whether the reaching condition of the controller holds; None: not yet controlled


if not TYPE_CHECKING:

    def __getattr__(name: str) -> Any:
        """The driver's interface, which stood here before; drivers that import it from here go on to work."""
        if name in ("Command", "Driver", "DriverSetup", "Observation", "Privilege", "Turn"):
            return getattr(import_module("vpf_sim.driver_interface"), name)
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
