"""The sections of a scenario: road, ego, goal, objects, limits.

Positions are s_m along the carriageway's centre line and metres right of a lane's centre; lanes are counted from the
right, from 1. Positive radii and heading changes turn right.
"""

from collections.abc import Iterable, Iterator
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, PositiveFloat, PositiveInt, model_validator

from vpf_sim.configuration import STRICT
from vpf_sim.scenarios.kinds import ObjectKind
from vpf_sim.scenarios.lane_places import LanePlaces

MOST_ROAD_M = 20_000.0  # longest road: lanes, paint and trees are built before the first frame
FASTEST_MPS = 60.0  # bounds of the observation space, as the next two
FARTHEST_M = 8e4  # distance of the road's start from the origin
LONGEST_S = 1e5

Ability = Literal[
    "keep-lane",
    "pass-static",
    "low-obstacles",
    "follow",
    "cut-in",
    "oncoming",
    "crossing",
    "marks-and-shadows",
    "worn-paint",
    "cameras",
]
Interval = Annotated[tuple[float, float], Field(strict=False)]  # TOML has lists only
Place = Annotated[float, Field(ge=-FARTHEST_M, le=FARTHEST_M)]
Degrees = Annotated[float, Field(ge=-360.0, le=360.0)]
Speed = Annotated[float, Field(ge=0.0, le=FASTEST_MPS)]
MOST_LANES = 20
Lanes = Annotated[int, Field(ge=1, le=MOST_LANES)]
LaneWidth = Annotated[float, Field(gt=0.0, le=20.0)]


class Section(BaseModel):
    """Base of all sections: frozen, without unknown keys, nan and inf."""

    model_config = ConfigDict(**STRICT, frozen=True, populate_by_name=True)
    added: ClassVar[frozenset[str]] = frozenset()  # fields that came later, of which the default is left out of repr

    def __repr_args__(self) -> Iterable[tuple[str | None, Any]]:
        """Without `added` fields at their default, so that the hash of a scenario stays what runs have stored."""
        fields = type(self).model_fields
        for key, value in super().__repr_args__():
            if key not in self.added or value != fields[key].default:
                yield key, value


class ConsistentSection(Section):
    """A section whose keys must fit together: `faults` yields a line for each that does not."""

    @model_validator(mode="after")
    def _fit_together(self) -> Self:
        found = list(self.faults())
        if found:
            raise ValueError("\n".join(found))
        return self

    def faults(self) -> Iterator[str]:
        """Every fault, for any seed."""
        raise NotImplementedError


class Exercise(ConsistentSection):
    """A whole scenario: it says what a driver must be able to do, for tables of success by ability.

    It drives the same whatever it says there, so its hash does not contain that.
    """

    abilities: Annotated[tuple[Ability, ...], Field(strict=False)] = Field(
        default=(), repr=False, description="What a driver must be able to do to arrive."
    )

    @model_validator(mode="after")
    def _names_each_ability_once(self) -> Self:
        twice = [ability for ability in dict.fromkeys(self.abilities) if self.abilities.count(ability) > 1]
        if twice:
            raise ValueError(f"abilities: expected each once, got {twice[0]} {self.abilities.count(twice[0])} times")
        return self


class Line(Section):
    kind: Literal["line"]
    length_m: PositiveFloat


class Arc(Section):
    kind: Literal["arc"]
    length_m: PositiveFloat
    radius_m: float = Field(description="Radius of the bend; positive turns right.")


class Clothoid(Section):
    """Curvature changes linearly with the distance, from the last segment's end."""

    kind: Literal["clothoid"]
    length_m: PositiveFloat
    end_radius_m: float | None = Field(
        default=None, description="Radius at the end; positive turns right, none ends straight."
    )


Segment = Annotated[Line | Arc | Clothoid, Field(discriminator="kind")]


class RoadAppearance(Section):
    """Appearance of a road: verge, surface and markings."""

    verge: Literal["grass", "sand", "snow", "paved"] = Field(default="grass", description="What lies beside the road.")
    surface: Literal["asphalt", "concrete", "dark"] = Field(default="asphalt", description="What the road is made of.")
    grain: Annotated[float, Field(ge=0.0, le=2.0)] = Field(
        default=1.0, description="Strength of the fine texture of road and verge; 0.3 is that of a new, smooth road."
    )
    worn: bool = Field(default=False, description="Whether 60 % of the paint's contrast is gone.")
    edge_lines: Literal["both", "left", "right", "none"] = Field(
        default="both", description="Which of the two solid lines are painted."
    )
    lines: Literal["white", "yellow"] = Field(default="white", description="Colour of all paint.")
    stripe_m: Annotated[float, Field(gt=0.0, le=50.0)] = Field(
        default=3.0, description="Length of the stripes of a lane line."
    )
    gap_m: Annotated[float, Field(gt=0.0, le=50.0)] = Field(
        default=6.0, description="Length of the gaps between the stripes of a lane line."
    )
    studs: bool = Field(default=False, description="Whether a round marker is in the middle of each gap.")
    double_lines: bool = Field(
        default=False, description="Whether solid lines between lanes, as before oncoming traffic, are double."
    )
    marks: bool = Field(
        default=False, description="Whether there are arrows and words in the lanes, stop lines and zebra crossings."
    )
    bus_lane: bool = Field(
        default=False,
        description="Whether the rightmost lane is a darker bus lane behind a broad line, with the word BUS.",
    )
    tram_rails: bool = Field(
        default=False, description="Whether rails lie in the leftmost lane, also of oncoming traffic."
    )
    kerbs: bool = Field(
        default=False, description="Whether kerb stones and a pavement, drawn flat, are beside the road."
    )
    hatching: bool = Field(
        default=False,
        description="Whether hatched areas narrow the outermost lanes by 1.35 m, or less where lanes are narrow.",
    )
    shadows: bool = Field(
        default=False, description="Whether trees, posts, signs and gantries cast shadows in the sun."
    )


class LaneWidths(Section):
    """The widths of all lanes at one place; between places they change linearly, beyond the ends they stay."""

    s_m: Annotated[float, Field(ge=0.0, le=MOST_ROAD_M)] = Field(description="Place of the widths along the road.")
    lanes_m: Annotated[tuple[LaneWidth, ...], Field(strict=False, min_length=1, max_length=MOST_LANES)] = Field(
        description="Width of each lane, from the right."
    )
    left_edge_m: Annotated[float, Field(ge=-400.0, le=400.0)] | None = Field(
        default=None,
        description="Left edge of the carriageway, right of the centre line; none: half the width to its left.",
    )


class Road(Section):
    added = frozenset({"widths"})

    look: RoadAppearance = RoadAppearance()
    lanes: Lanes = Field(default=4, description="Number of lanes, oncoming ones included.")
    lane_width_m: LaneWidth = Field(default=3.5, description="Width of each lane.")
    widths: Annotated[tuple[LaneWidths, ...], Field(strict=False)] = Field(
        default=(), description="Widths of lanes that differ or change along the road, in place of `lane_width_m`."
    )
    oncoming_lanes: Annotated[int, Field(ge=0, le=19)] = Field(
        default=0, description="Number of the lanes on the left that are oncoming, beyond a solid line."
    )
    start_m: Annotated[tuple[Place, Place], Field(strict=False)] = Field(
        default=(0.0, 0.0), description="Start of the carriageway's centre line, along which s_m runs."
    )
    heading_deg: Degrees = Field(default=0.0, description="Heading of the first segment.")
    segments: Annotated[tuple[Segment, ...], Field(strict=False, min_length=1)]

    @property
    def length_m(self) -> float:
        return sum(segment.length_m for segment in self.segments)

    @property
    def own_lanes(self) -> int:
        """Lanes in the ego's direction."""
        return self.lanes - self.oncoming_lanes

    @property
    def half_width_m(self) -> float:
        """m, the largest distance of an edge from the centre line."""
        return self.lane_places.widest_m if self.lane_places else self.lanes * self.lane_width_m / 2.0

    def reach_within(self, low_m: float, high_m: float) -> tuple[float, float]:
        """(left, right) m, how far the edges are from the centre line at most between two s."""
        places = self.lane_places
        return places.reach_within(low_m, high_m) if places else (self.half_width_m, self.half_width_m)

    @property
    def lane_places(self) -> LanePlaces | None:
        """Where the lanes lie along the road; none where all have `lane_width_m`."""
        return LanePlaces(self.widths) if self.widths else None

    def lane_offset_m(self, lane: int, s_m: float = 0.0) -> float:
        """m, a lane's centre right of the centre line at s."""
        if (places := self.lane_places) is not None:
            return float(places.middle(lane, s_m))
        return (self.lanes / 2.0 - lane + 0.5) * self.lane_width_m

    def edges_m(self, low_m: float, high_m: float) -> tuple[float, float]:
        """(left, right) m, the narrowest edges between two s, right of the centre line."""
        if (places := self.lane_places) is not None:
            return places.edges_within(low_m, high_m)
        return -self.half_width_m, self.half_width_m


Spread = Annotated[float, Field(ge=0.0, le=100.0)]


class Sensors(Section):
    """Standard deviations of the ego's sensor errors; scale, bias and mounting are drawn once."""

    position_noise_m: Spread = Field(default=0.0, description="Standard deviation of each position.")
    position_walk_m: Spread = Field(
        default=0.0,
        description="Standard deviation of the position's random walk after a second.",
    )
    heading_noise_deg: Spread = Field(default=0.0, description="Standard deviation of each heading.")
    heading_walk_deg: Spread = Field(
        default=0.0, description="Standard deviation of the heading's random walk after a second."
    )
    speed_scale: Annotated[float, Field(ge=0.0, le=1.0)] = Field(
        default=0.0, description="Standard deviation of the speedometer's scale error, drawn once an episode."
    )
    speed_noise_mps: Spread = Field(default=0.0, description="Standard deviation of each speed.")
    yaw_rate_bias_radps: Spread = Field(
        default=0.0, description="Standard deviation of the yaw rate's bias, drawn once an episode."
    )
    yaw_rate_noise_radps: Spread = Field(default=0.0, description="Standard deviation of each yaw rate.")
    mounting_deg: Annotated[float, Field(ge=0.0, le=10.0)] = Field(
        default=0.0,
        description="Standard deviation of a camera pitch that the driver does not know, drawn once an episode.",
    )
    pitch_deg: Annotated[float, Field(ge=0.0, le=10.0)] = Field(
        default=0.0, description="Standard deviation of the body's pitch on its springs, at 1.5 Hz."
    )


Share = Annotated[float, Field(ge=0.0, le=1.0)]
Seconds = Annotated[float, Field(gt=0.0, le=LONGEST_S)]


class SensorFaults(Section):
    """Faults of the ego's sensors, none by default; shares refer to all frames or all samples."""

    drop_share: Share = Field(default=0.0, description="Share of frames that never arrive.")
    latency_ms: Annotated[float, Field(ge=0.0, le=2000.0)] = Field(
        default=0.0, description="Time from the exposure of a frame to its arrival."
    )
    freeze_share: Share = Field(
        default=0.0, description="Share of frames that repeat an earlier picture under a new time stamp, in stretches."
    )
    freeze_s: Seconds = Field(default=0.5, description="Length of a frozen stretch.")
    black_share: Share = Field(default=0.0, description="Share of frames that are black.")
    torn_share: Share = Field(default=0.0, description="Share of frames whose lower part is that of the frame before.")
    noise_rows_share: Share = Field(default=0.0, description="Share of frames with a band of rows of noise.")
    exposure_jump_share: Share = Field(default=0.0, description="Share of frames that are brighter or darker.")
    exposure_jump_stops: Annotated[float, Field(gt=0.0, le=8.0)] = Field(
        default=1.0, description="Size of an exposure jump, in factors of 2."
    )
    speed_stuck_after_s: Seconds | None = Field(
        default=None, description="Time from which the speedometer repeats its value."
    )
    yaw_rate_spike_share: Share = Field(default=0.0, description="Share of yaw rates with a spike.")
    yaw_rate_spike_radps: Annotated[float, Field(gt=0.0, le=100.0)] = Field(
        default=1.0, description="Size of a spike of the yaw rate, to either side."
    )

    @property
    def affect_camera(self) -> bool:
        """Whether any frame may be affected."""
        shares = (self.drop_share, self.freeze_share, self.black_share, self.torn_share, self.noise_rows_share)
        return any(share > 0.0 for share in (*shares, self.exposure_jump_share, self.latency_ms))

    @property
    def affect_signals(self) -> bool:
        """Whether speed or yaw rate may be affected."""
        return self.speed_stuck_after_s is not None or self.yaw_rate_spike_share > 0.0


CameraName = Literal["default", "dash-cam", "phone", "kitti"]


class Ego(Section):
    camera: CameraName = Field(default="default", description="Camera: 640 x 480 pixels over 90 deg, or another one.")
    sensors: Sensors = Sensors()
    sensor_faults: SensorFaults = SensorFaults()
    lane: PositiveInt = Field(default=2, description="Lane of the start, counted from the right, from 1.")
    s_m: float = Field(default=5.0, description="Start along the road.")
    lateral_m: float = Field(default=0.0, description="Start beside the lane's centre, positive to the right.")
    heading_deg: Degrees = Field(default=0.0, description="Heading relative to the road.")
    speed_mps: Speed = Field(default=5.55, description="Speed at the start.")
    speed_reference_mps: Annotated[float, Field(gt=0.0, le=FASTEST_MPS)] = Field(
        default=5.55, description="Speed to drive at."
    )


class Goal(Section):
    s_m: float = Field(description="Place of the goal along the road.")
    kind: Literal["reach", "stop"] = Field(
        default="reach", description="What the car does at the goal: cross its line, or stop before it."
    )


class Manoeuvre(Section):
    """A change of an actor's motion. It begins after the one before, when its time or its distance has come."""

    after_s: Annotated[float, Field(ge=0.0, le=LONGEST_S)] | None = Field(
        default=None, description="Time since the manoeuvre before began, or since the start."
    )
    within_m: Annotated[float, Field(gt=0.0, le=FARTHEST_M)] | None = Field(
        default=None,
        description="Free road between actor and ego at which the manoeuvre begins, in place of `after_s`.",
    )
    speed_mps: Speed | None = Field(default=None, description="Speed to drive at from then on.")
    rate_mps2: Annotated[float, Field(gt=0.0, le=12.0)] = Field(
        default=2.0, description="Deceleration or acceleration of the change of speed."
    )
    lateral_m: float | None = Field(
        default=None, description="Place to move to, from the lane's centre, positive to the right."
    )
    lateral_mps: Annotated[float, Field(gt=0.0, le=12.0)] = Field(
        default=1.0, description="Speed of the move to the side."
    )


class ObjectSpec(Section):
    kind: ObjectKind = Field(description="Kind of the object.")
    s_m: float = Field(description="Place along the road.")
    lane: PositiveInt = Field(description="Lane, counted from the right, from 1.")
    lateral_m: float = Field(default=0.0, description="Place beside the lane's centre, positive to the right.")
    speed_mps: Speed = Field(default=0.0, description="Speed; an object with a speed is traffic.")
    oncoming: bool = Field(default=False, description="Whether it faces and drives against the ego.")
    manoeuvres: Annotated[tuple[Manoeuvre, ...], Field(strict=False)] = Field(
        default=(), description="Manoeuvres of traffic, in order."
    )

    @property
    def is_actor(self) -> bool:
        """Whether it may move."""
        return self.speed_mps > 0.0 or bool(self.manoeuvres)


class Limits(Section):
    time_s: Annotated[float, Field(gt=0.0, le=LONGEST_S)] = Field(description="Time until the timeout.")


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
