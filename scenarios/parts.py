"""The sections of a scenario: road, ego, goal, objects, limits.

Positions are s_m along the carriageway's centre line and metres right of a lane's centre; lanes are counted from the
right, from 1. Positive radii and heading changes turn right.
"""

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, PositiveFloat, PositiveInt

from vpf_sim.scenarios.kinds import ObjectKind

MOST_ROAD_M = 20_000.0  # longest road: lanes, paint and trees are built before the first frame
FASTEST_MPS = 60.0  # bounds of the observation space, as the next two
FARTHEST_M = 8e4  # distance of the road's start from the origin
LONGEST_S = 1e5

Interval = Annotated[tuple[float, float], Field(strict=False)]  # TOML has lists only
Place = Annotated[float, Field(ge=-FARTHEST_M, le=FARTHEST_M)]
Degrees = Annotated[float, Field(ge=-360.0, le=360.0)]
Speed = Annotated[float, Field(ge=0.0, le=FASTEST_MPS)]
Lanes = Annotated[int, Field(ge=1, le=20)]
LaneWidth = Annotated[float, Field(gt=0.0, le=20.0)]


class Section(BaseModel):
    """Base of all sections: frozen, without unknown keys, nan and inf."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False, populate_by_name=True)


class Line(Section):
    kind: Literal["line"]
    length_m: PositiveFloat


class Arc(Section):
    kind: Literal["arc"]
    length_m: PositiveFloat
    radius_m: float  # > 0 turns right


class Clothoid(Section):
    """Curvature changes linearly with the distance, from the last segment's end."""

    kind: Literal["clothoid"]
    length_m: PositiveFloat
    end_radius_m: float | None = None  # > 0 turns right; None ends straight


Segment = Annotated[Line | Arc | Clothoid, Field(discriminator="kind")]


class RoadAppearance(Section):
    """Appearance of a road: verge, surface and markings."""

    verge: Literal["grass", "sand", "snow", "paved"] = "grass"
    surface: Literal["asphalt", "concrete", "dark"] = "asphalt"
    worn: bool = False  # worn paint
    edge_lines: Literal["both", "left", "right", "none"] = "both"  # painted edge lines


class Road(Section):
    look: RoadAppearance = RoadAppearance()
    lanes: Lanes = 4
    lane_width_m: LaneWidth = 3.5
    start_m: Annotated[tuple[Place, Place], Field(strict=False)] = (0.0, 0.0)
    heading_deg: Degrees = 0.0
    segments: Annotated[tuple[Segment, ...], Field(strict=False, min_length=1)]

    @property
    def length_m(self) -> float:
        return sum(segment.length_m for segment in self.segments)

    @property
    def half_width_m(self) -> float:
        return self.lanes * self.lane_width_m / 2.0

    def lane_offset_m(self, lane: int) -> float:
        """m, a lane's centre right of the carriageway's centre."""
        return (self.lanes / 2.0 - lane + 0.5) * self.lane_width_m


Spread = Annotated[float, Field(ge=0.0, le=100.0)]


class Sensors(Section):
    """Standard deviations of the ego's sensor errors; scale, bias and mounting are drawn once."""

    position_noise_m: Spread = 0.0  # per reading
    position_walk_m: Spread = 0.0  # after one second; grows with the square root of time
    heading_noise_deg: Spread = 0.0
    heading_walk_deg: Spread = 0.0
    speed_scale: Annotated[float, Field(ge=0.0, le=1.0)] = 0.0  # share
    speed_noise_mps: Spread = 0.0
    yaw_rate_bias_radps: Spread = 0.0
    yaw_rate_noise_radps: Spread = 0.0
    mounting_deg: Annotated[float, Field(ge=0.0, le=10.0)] = 0.0  # pitch error of the camera's mounting
    pitch_deg: Annotated[float, Field(ge=0.0, le=10.0)] = 0.0  # pitch of the sprung body


Share = Annotated[float, Field(ge=0.0, le=1.0)]
Seconds = Annotated[float, Field(gt=0.0, le=LONGEST_S)]


class SensorFaults(Section):
    """Faults of the ego's sensors, none by default; shares refer to all frames or all readings."""

    drop_share: Share = 0.0  # lost frames
    latency_ms: Annotated[float, Field(ge=0.0, le=2000.0)] = 0.0  # from exposure to arrival
    freeze_share: Share = 0.0  # frames that repeat an earlier image under new time stamps
    freeze_s: Seconds = 0.5  # duration of one freeze
    black_share: Share = 0.0
    torn_share: Share = 0.0  # frames with the lower part of the previous one
    noise_rows_share: Share = 0.0  # frames with a band of noise
    exposure_jump_share: Share = 0.0  # overexposed or underexposed frames
    exposure_jump_stops: Annotated[float, Field(gt=0.0, le=8.0)] = 1.0  # size of a jump in stops, factors of 2
    speed_stuck_after_s: Seconds | None = None  # time from which the speedometer repeats its reading
    yaw_rate_spike_share: Share = 0.0  # yaw rate readings with a spike
    yaw_rate_spike_radps: Annotated[float, Field(gt=0.0, le=100.0)] = 1.0  # size of a spike, of either sign

    @property
    def affect_camera(self) -> bool:
        """Whether any frame may be affected."""
        shares = (self.drop_share, self.freeze_share, self.black_share, self.torn_share, self.noise_rows_share)
        return any(share > 0.0 for share in (*shares, self.exposure_jump_share, self.latency_ms))

    @property
    def affect_signals(self) -> bool:
        """Whether speed or yaw rate may be affected."""
        return self.speed_stuck_after_s is not None or self.yaw_rate_spike_share > 0.0


class Ego(Section):
    sensors: Sensors = Sensors()
    sensor_faults: SensorFaults = SensorFaults()
    lane: PositiveInt = 2
    s_m: float = 5.0
    lateral_m: float = 0.0  # + is right
    heading_deg: Degrees = 0.0  # relative to the road
    speed_mps: Speed = 5.55
    speed_reference_mps: Annotated[float, Field(gt=0.0, le=FASTEST_MPS)] = 5.55


class Goal(Section):
    s_m: float
    kind: Literal["reach", "stop"] = "reach"


class ObjectSpec(Section):
    kind: ObjectKind
    s_m: float
    lane: PositiveInt
    lateral_m: float = 0.0  # + is right
    speed_mps: Speed = 0.0  # > 0: traffic


class Limits(Section):
    time_s: Annotated[float, Field(gt=0.0, le=LONGEST_S)]


VaryKey = Literal[
    "ego.s_m",
    "ego.lateral_m",
    "ego.heading_deg",
    "ego.speed_mps",
    "bodies.s_m",
    "bodies.lateral_m",
    "bodies.speed_mps",
]

Vary = dict[VaryKey, Interval]  # [low, high] of a uniform draw that is added
