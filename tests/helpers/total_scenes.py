"""Random scenes for the planner: any finite road, obstacles, flow, pose and speed, the extreme ones among them."""

from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
from flow_between import flow_between
from hypothesis import strategies as st

from vpf_sim.driver_interface import DriverSetup, Observation
from vpf_sim.planning import variant
from vpf_sim.planning.variant import Variant
from vpf_sim.types import (
    Camera,
    Expansion,
    Floats,
    Flow,
    KnownFeatures,
    LowObstacleRange,
    ObstacleMap,
    Obstacles,
    Perception,
    RoadEdges,
    VehicleModel,
)

CAMERA, VEHICLE = Camera(), VehicleModel()
MOST = float(np.finfo(float).max)
VARIANTS = variant.names()
NO_IMAGE = np.zeros((0, 0, 3), np.uint8)

load: Any = cache(variant.load)


def near(least: float, most: float) -> st.SearchStrategy[float]:
    """Mostly values that occur on a road, and now and then any other that is finite."""
    usual = st.floats(least, most)
    return st.one_of(*[usual] * 30, st.floats(allow_nan=False, allow_infinity=False))


LENGTHS = near(-30.0, 30.0)
ANGLES = near(-0.6, 0.6)
SHARES = st.floats(0.0, 1.0)
SPEEDS = st.one_of(st.just(0.0), st.floats(0.0, 3.0), st.floats(0.0, 60.0))
PLACES = st.one_of(st.floats(-100.0, 100.0), st.floats(-1e9, 1e9))


@st.composite
def roads(draw: st.DrawFn) -> RoadEdges:
    """Any edges, on the wrong side of the car, too; a lane has a width."""
    left, right, lane = draw(near(-15.0, 3.0)), draw(near(-3.0, 15.0)), draw(near(-4.0, 4.0))
    heading, curvature = draw(ANGLES), draw(near(-0.2, 0.2))
    width = draw(st.floats(0.1, 30.0))
    return RoadEdges(left, right, heading, curvature, draw(near(0.0, 1.0)), draw(SHARES), lane, width, draw(SHARES))


@st.composite
def bodies(draw: st.DrawFn) -> Obstacles:
    """Up to five: ahead, beside and behind, one in the other, standing and moving, of any width."""
    count = draw(st.integers(0, 5))

    def column(values: st.SearchStrategy[float]) -> Floats:
        return np.array(draw(st.lists(values, min_size=count, max_size=count)), dtype=float)

    one, other = column(near(-6.0, 6.0)), column(near(-6.0, 6.0))
    moves = column(st.one_of(st.just(0.0), st.floats(0.0, 60.0)))
    names = draw(st.lists(st.integers(-5, 5), min_size=count, max_size=count))
    return Obstacles(
        forward_m=column(near(-10.0, 40.0)),
        left_m=np.minimum(one, other),
        right_m=np.maximum(one, other),
        sigma_m=column(near(0.0, 2.0)),
        ttc_s=column(st.one_of(st.just(np.inf), st.floats(0.0, 1e9))),
        identity=np.array(names, dtype=np.int64),
        speed_mps=moves,
    )


def flow(points: Floats, pose: Floats) -> Flow:
    """Points (N, 2) px that have stayed where they are for a tenth of a second."""
    return replace(flow_between(points, points, pose, pose), age_frames=np.arange(len(points)))


@st.composite
def perceptions(draw: st.DrawFn, pose: Floats) -> Perception:
    """The perception of a frame."""
    count = draw(st.integers(0, 4))
    points = np.array(draw(st.lists(st.floats(0.0, 479.0), min_size=2 * count, max_size=2 * count))).reshape(-1, 2)
    ttc = np.array(draw(st.lists(st.one_of(st.just(np.inf), LENGTHS), min_size=count, max_size=count)), dtype=float)
    gradient = np.full((2, 6, 8), draw(st.floats(-1.0, 1.0)))  # of a plane of zeros and ones
    seen = ObstacleMap(np.ones(count, np.bool_), np.zeros((6, 8)), gradient, 80)
    foe = Expansion(draw(near(0.0, 639.0)), draw(near(0.0, 479.0)), np.eye(2), np.ones(count, np.bool_), draw(SHARES))
    sight = draw(st.one_of(st.just((np.inf, np.inf)), st.tuples(near(0.0, 40.0), near(0.0, 40.0))))
    road, obstacles = draw(roads()), draw(bodies())
    return Perception(
        flow(points, pose), foe, KnownFeatures(seen, ttc), obstacles, road, pose, LowObstacleRange(*sight)
    )


@dataclass(frozen=True)
class Moment:
    """What is seen and measured, for some frames in a row."""

    perception: Perception
    observation: Observation
    frames: int


@st.composite
def moments(draw: st.DrawFn, goal_m: tuple[float, float]) -> Moment:
    """A car that stands may do so for long: the driver looks for a way out then."""
    x, y, yaw = draw(PLACES), draw(PLACES), draw(near(-3.2, 3.2))
    speed, rate = draw(SPEEDS), draw(near(-1.0, 1.0))
    observation = Observation(NO_IMAGE, 0.0, x, y, yaw, speed, rate, goal_m)
    frames = draw(st.integers(1, 40 if speed == 0.0 else 15))
    return Moment(draw(perceptions(np.array([x, y, yaw]))), observation, frames)


@dataclass(frozen=True)
class Drive:
    """A setup, and what comes then."""

    setup: DriverSetup
    variant: str
    moments: list[Moment]

    @property
    def configuration(self) -> Variant:
        found: Variant = load(self.variant)
        return found

    def frames(self) -> list[tuple[Perception, Observation]]:
        """Each with the time at which it is."""
        held = [moment for moment in self.moments for _ in range(moment.frames)]
        dt_s = 1.0 / self.setup.rate_hz
        return [(one.perception, replace(one.observation, time_s=k * dt_s)) for k, one in enumerate(held)]


@st.composite
def setups(draw: st.DrawFn) -> DriverSetup:
    """Any reference speed and goal, at the rates of cameras."""
    goal = draw(PLACES), draw(PLACES)
    return DriverSetup(CAMERA, VEHICLE, draw(st.floats(5.0, 120.0)), draw(SPEEDS), goal, draw(st.integers(0, 9)))


@st.composite
def drives(draw: st.DrawFn) -> Drive:
    """A few moments that have nothing to do with each other: every state meets every scene."""
    setup = draw(setups())
    scenes = draw(st.lists(moments(setup.goal_m), min_size=1, max_size=4))
    return Drive(setup, draw(st.sampled_from(VARIANTS)), scenes)
