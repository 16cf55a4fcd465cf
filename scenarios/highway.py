"""Scenarios on the roads of highway-env's own environments, with its traffic."""

from collections.abc import Iterator
from typing import Annotated, Literal, get_args

from pydantic import Field

from vpf_sim.scenarios.parts import (
    FASTEST_MPS,
    MOST_ROAD_M,
    CameraName,
    Exercise,
    Lanes,
    Limits,
    Section,
    SensorFaults,
    Sensors,
    Share,
    Speed,
)

HighwayId = Literal[
    "highway-v0",
    "highway-fast-v0",
    "merge-v0",
    "merge-v1",
    "merge-generic-v0",
    "merge-generic-v1",
    "exit-v0",
    "exit-v1",
    "roundabout-v0",
    "roundabout-v1",
    "roundabout-generic-v0",
    "roundabout-generic-v1",
    "two-way-v0",
    "lane-keeping-v0",
    "racetrack-v0",
    "racetrack-v1",
    "racetrack-large-v0",
    "racetrack-large-v1",
    "racetrack-oval-v0",
    "racetrack-oval-v1",
    "u-turn-v0",
    "u-turn-v1",
    "intersection-v0",
    "intersection-v1",
    "intersection-v2",
]
TrafficModel = Literal[
    "highway_env.vehicle.behavior.IDMVehicle",
    "highway_env.vehicle.behavior.LinearVehicle",
    "highway_env.vehicle.behavior.AggressiveVehicle",
    "highway_env.vehicle.behavior.DefensiveVehicle",
]
Cars = Annotated[int, Field(ge=0, le=200)]

ANY_TRAFFIC = ("other_vehicles_type", "neighbour_vehicles_connected_lanes")
MANY_CARS = ("lanes_count", "vehicles_count", "vehicles_density", "ego_spacing", *ANY_TRAFFIC)
MERGE_LENGTHS = ("before_merge_length", "converge_merge_length", "parallel_merge_length", "after_merge_length")
RACE_TRAFFIC = ("other_vehicles", "neighbour_vehicles_connected_lanes")
KEYS = {  # of all versions of an environment
    "highway": (*MANY_CARS, "initial_lane_id"),
    "highway-fast": (*MANY_CARS, "initial_lane_id"),
    "merge": ANY_TRAFFIC,
    "merge-generic": ("lanes_count", "vehicles_count", *MERGE_LENGTHS, *ANY_TRAFFIC),
    "exit": MANY_CARS,
    "roundabout": ("incoming_vehicle_destination", *ANY_TRAFFIC),
    "roundabout-generic": (
        "roundabout_radius",
        "roundabout_lanes",
        "vehicles_count",
        "incoming_vehicle_destination",
        *ANY_TRAFFIC,
    ),
    "two-way": ANY_TRAFFIC,
    "lane-keeping": (),
    "racetrack": RACE_TRAFFIC,
    "racetrack-large": RACE_TRAFFIC,
    "racetrack-oval": ("length", "block_lane", "force_decision", *RACE_TRAFFIC),
    "u-turn": ANY_TRAFFIC,
    "intersection": ("destination", "initial_vehicle_count", "spawn_probability", *ANY_TRAFFIC),
}


def without_version(name: str) -> str:
    """An id without its version: "roundabout" of "roundabout-v1"."""
    return name.rpartition("-v")[0]


CONFIG_KEYS: dict[HighwayId, tuple[str, ...]] = {name: KEYS[without_version(name)] for name in get_args(HighwayId)}
OWN_LANES = {"highway-v0": 4, "highway-fast-v0": 3}  # highway-env's lanes_count


class HighwayConfig(Section):
    """Keys of highway-env's configuration that change road or traffic; none: highway-env's own value.

    Each environment has some of them. Rewards, actions, observations and rendering of highway-env are not used.
    """

    added = frozenset({
        "after_merge_length", "before_merge_length", "block_lane", "converge_merge_length", "force_decision", "length",
        "parallel_merge_length", "roundabout_lanes", "roundabout_radius",
    })  # fmt: skip

    lanes_count: Lanes | None = Field(default=None, description="Number of lanes.")
    vehicles_count: Cars | None = Field(default=None, description="Number of other cars.")
    vehicles_density: Annotated[float, Field(gt=0.0, le=10.0)] | None = Field(
        default=None, description="Density of the other cars; above 1 they are closer together."
    )
    ego_spacing: Annotated[float, Field(ge=0.0, le=10.0)] | None = Field(
        default=None, description="Gap before the ego, as a multiple of the usual one."
    )
    initial_lane_id: Annotated[int, Field(ge=0)] | None = Field(
        default=None, description="Lane of the ego, where 0 is the leftmost; drawn by default."
    )
    other_vehicles_type: TrafficModel | None = Field(default=None, description="Class of the other cars.")
    other_vehicles: Cars | None = Field(default=None, description="Number of other cars.")
    neighbour_vehicles_connected_lanes: bool | None = Field(
        default=None, description="Whether cars also heed those on the next and the previous road."
    )
    incoming_vehicle_destination: Annotated[int, Field(ge=0, le=2)] | None = Field(
        default=None, description="Entry of the ego: 0 is east, 1 south, 2 north; drawn by default."
    )
    destination: Literal["o1", "o2", "o3", "random"] | None = Field(
        default=None, description="Exit: o1 turns left, o2 goes straight on, o3 turns right."
    )
    before_merge_length: Annotated[int, Field(ge=60, le=2000)] | None = Field(
        default=None, description="Length in m of the road before the ramp comes nearer."
    )
    converge_merge_length: Annotated[int, Field(ge=20, le=500)] | None = Field(
        default=None, description="Length in m over which the ramp comes nearer."
    )
    parallel_merge_length: Annotated[int, Field(ge=20, le=2000)] | None = Field(
        default=None, description="Length in m over which the ramp is a lane of the road."
    )
    after_merge_length: Annotated[int, Field(ge=90, le=2000)] | None = Field(
        default=None, description="Length in m of the road after the ramp's end."
    )
    roundabout_radius: Annotated[int, Field(ge=15, le=100)] | None = Field(
        default=None, description="Radius in m of the innermost lane's centre."
    )
    roundabout_lanes: Annotated[int, Field(ge=1, le=4)] | None = Field(
        default=None, description="Number of lanes of the roundabout."
    )
    length: Annotated[int, Field(ge=60, le=1000)] | None = Field(
        default=None, description="Length of the long straights in m."
    )
    block_lane: bool | None = Field(
        default=None, description="Whether barriers stand on the middle lane of the first straight."
    )
    force_decision: bool | None = Field(
        default=None, description="Whether barriers stand on the first and the third lane."
    )
    initial_vehicle_count: Cars | None = Field(default=None, description="Largest number of cars at the start.")
    spawn_probability: Share | None = Field(default=None, description="Probability of a new car in each second.")

    def given(self) -> dict[str, object]:
        """The keys with a value."""
        return {key: value for key, value in self if value is not None}


class HighwayEnv(Section):
    """An environment of highway-env: its road, its traffic, and where its ego starts."""

    id: HighwayId = Field(description="Name of the environment.")
    config: HighwayConfig = HighwayConfig()
    traffic: bool = Field(default=True, description="Whether there are other cars.")


class HighwayEgo(Section):
    """The ego of a highway-env road; place, heading and speed at the start are highway-env's."""

    camera: CameraName = Field(default="default", description="Camera: 640 x 480 pixels over 90 deg, or another one.")
    sensors: Sensors = Sensors()
    sensor_faults: SensorFaults = SensorFaults()
    speed_mps: Speed | None = Field(default=None, description="Speed at the start; highway-env's by default.")
    speed_reference_mps: Annotated[float, Field(gt=0.0, le=FASTEST_MPS)] = Field(description="Speed to drive at.")


class HighwayGoal(Section):
    route_m: Annotated[float, Field(gt=0.0, le=MOST_ROAD_M / 2.0)] = Field(
        description="Length of the route; the goal is nearer where the lanes end before."
    )
    kind: Literal["reach"] = Field(default="reach", description="What the car does at the goal: cross its line.")


class HighwayScenario(Exercise):
    """A scenario file with a section `highway_env` in place of `road` and `bodies`.

    It is laid over the catalog's scenario of its id. The seed is highway-env's: it draws the traffic and the start.
    """

    version: Literal[1] = Field(alias="schema")
    highway_env: HighwayEnv
    ego: HighwayEgo
    goal: HighwayGoal
    limits: Limits | None = None

    def faults(self) -> Iterator[str]:
        """Every fault, for any seed."""
        name, given = self.highway_env.id, self.highway_env.config.given()
        known = CONFIG_KEYS[name]
        for key in given.keys() - set(known):
            yield f"highway_env.config.{key}: expected a key of {name} ({', '.join(known) or 'it has none'}), got {key}"
        lane, lanes = given.get("initial_lane_id"), given.get("lanes_count", OWN_LANES.get(name, 0))
        if name in OWN_LANES and isinstance(lane, int) and isinstance(lanes, int) and lane >= lanes:
            yield f"highway_env.config.initial_lane_id: expected 0 to {lanes - 1}, the rightmost lane, got {lane}"

    @property
    def time_limit_s(self) -> float:
        """s, time limit; by default three times the route's duration at the reference speed."""
        if self.limits is not None:
            return self.limits.time_s
        return 3.0 * self.goal.route_m / self.ego.speed_reference_mps

    def draw(self, seed: int) -> "HighwayScenario":  # noqa: ARG002
        """The scenario itself: highway-env draws traffic and start when the world is built."""
        return self

    def without_objects(self) -> "HighwayScenario":
        """The same road and start without traffic and obstacles."""
        empty = self.highway_env.model_copy(update={"traffic": False})
        return self.model_copy(update={"highway_env": empty})
