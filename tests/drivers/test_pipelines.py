"""The planner on tracks that are projected from known points: what it sees, and that no direction is special."""

from dataclasses import replace
from math import radians

import numpy as np
import pytest

from vpf_sim.controllers.gtsmc import Gtsmc, load_gains
from vpf_sim.driver_interface import Command, DriverSetup, Observation
from vpf_sim.drivers.paper_pipeline import FrameTrackers
from vpf_sim.drivers.perceiver import Perceiver
from vpf_sim.geometry import project, rotation, vehicle_from_world, wrap_angle
from vpf_sim.perception.paper import obstacle_map as obstacles
from vpf_sim.planning import variant
from vpf_sim.planning.lane.planner import LanePlan
from vpf_sim.planning.planner import create_planner
from vpf_sim.planning.variant import Variant
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Floats, Flow, Image, Plan, RoadEdges, VehicleModel

CAMERA, CAR = Camera(), VehicleModel()
RATE_HZ, SPEED_MPS, FRAMES = 60.0, 5.55, 50
STRUCTURE = np.array([[900.0, 0.0], [0.0, 900.0]])


class Scene:
    """Points of the road and of a body 20 m ahead, 0.6 m right; a car drives along X past them, yawed a little."""

    def __init__(self) -> None:
        random = stream(1, "scene")
        road = np.column_stack([random.uniform(4.0, 40.0, 250), random.uniform(-8.0, 5.0, 250), np.zeros(250)])
        body = np.column_stack([np.full(40, 20.0), random.uniform(-0.4, 1.6, 40), random.uniform(0.3, 1.3, 40)])
        self._points_m = np.concatenate([road, body])
        self._noise_px = 0.03 * random.standard_normal((FRAMES, len(self._points_m), 2))

    def pose(self, frame: int) -> Floats:
        return np.array([SPEED_MPS * frame / RATE_HZ, 0.1, radians(1.0)])

    def flow(self, frame: int, every: int) -> Flow:
        """Of a frame; one in `every` is looked at."""
        start, window = 0, max(0, frame - 6)
        now, past, first = (self._pixels(k) for k in (frame, window, start))
        edge = [CAMERA.width_px - 1, CAMERA.height_px - 1]
        seen = [np.all((p >= 0.0) & (p <= edge), axis=1) for p in (now, past, first)]
        chosen = np.flatnonzero(seen[0] & seen[1] & seen[2])
        count = len(chosen)
        return Flow(
            points_px=now[chosen],
            displacement_px=(now - past)[chosen],
            gap_s=np.full(count, (frame - window) / RATE_HZ),
            past_pose=np.tile(self.pose(window), (count, 1)),
            pose=self.pose(frame),
            identity=chosen.astype(np.int64),
            first_px=first[chosen],
            first_pose=np.tile(self.pose(start), (count, 1)),
            age_frames=np.full(count, (frame - start) // every),
            structure=np.tile(STRUCTURE, (count, 1, 1)),
        )

    def edges(self, frame: int) -> RoadEdges:
        place = 1.75 + self.pose(frame)[1]
        return RoadEdges(-7.0 - place, 7.0 - place, -radians(1.0), 0.002, 0.02, 1.0, 1.75 - place, 3.5)

    def _pixels(self, frame: int) -> Floats:
        flat = vehicle_from_world(self._points_m[:, :2], self.pose(frame))
        with np.errstate(invalid="ignore"):
            return project(CAMERA, np.column_stack([flat, self._points_m[:, 2]])) + self._noise_px[frame]


class Moved:
    """A rigid motion of the world, or its mirror image in the X axis: left for right."""

    def __init__(self, turn_rad: float = 0.0, shift_m: tuple[float, float] = (0.0, 0.0), mirror: bool = False) -> None:
        self._turn_rad, self._shift_m, self._mirror = turn_rad, np.array(shift_m), mirror

    def pose(self, pose: Floats) -> Floats:
        x, y, yaw = np.moveaxis(pose, -1, 0)
        if self._mirror:
            return np.stack([x, -y, -yaw], axis=-1)
        places = np.stack([x, y], axis=-1) @ rotation(self._turn_rad).T + self._shift_m
        return np.concatenate([places, np.asarray(yaw + self._turn_rad)[..., None]], axis=-1)

    def flow(self, flow: Flow) -> Flow:
        moved = replace(
            flow, pose=self.pose(flow.pose), past_pose=self.pose(flow.past_pose), first_pose=self.pose(flow.first_pose)
        )
        if not self._mirror:
            return moved
        size = np.array([2.0 * CAMERA.cx_px, 0.0])
        flip = np.array([-1.0, 1.0])
        return replace(
            moved,
            points_px=size + flip * flow.points_px,
            first_px=size + flip * flow.first_px,
            displacement_px=flip * flow.displacement_px,
        )

    def edges(self, road: RoadEdges) -> RoadEdges:
        if not self._mirror:
            return road
        heading, curvature = -road.heading_rad, -road.curvature_per_m
        return RoadEdges(
            -road.right_m,
            -road.left_m,
            heading,
            curvature,
            road.sigma_m,
            road.confidence,
            -road.lane_m,
            road.lane_width_m,
        )


class Passes:
    """Stands in for the gate of frames: the pictures are blank."""

    def passes(self, *_: object) -> bool:
        return True


class Replayed:
    """Stands in for the flow and the road tracker: gives what was prepared."""

    pitch, is_swept = None, False

    def __init__(self, records: list[object], rate_hz: float) -> None:
        self._records, self.rate_hz = iter(records), rate_hz

    def update(self, *_: object, **__: object) -> object:
        return next(self._records)

    def predicted(self, *_: object) -> object:
        return next(self._records)

    def turn(self, down_rad: float) -> None:
        assert down_rad == 0.0


def drive(configuration: Variant, moved: Moved, goal_m: Floats) -> list[tuple[Plan, Command]]:
    """Plans and commands of all frames."""
    scene = Scene()
    gx, gy, _ = moved.pose(np.array([*goal_m, 0.0]))
    goal = (float(gx), float(gy))
    setup = DriverSetup(CAMERA, CAR, RATE_HZ, SPEED_MPS, goal, 5)
    frames = range(1, FRAMES)
    every = round(RATE_HZ / Perceiver(setup, configuration).frame_rate_hz)
    trackers = replace(
        FrameTrackers.create(setup, configuration, RATE_HZ / every),
        flow=Replayed([moved.flow(scene.flow(k, every)) for k in frames[::every]], RATE_HZ / every),  # type: ignore[arg-type]
        road=Replayed([moved.edges(scene.edges(k)) for k in frames], RATE_HZ),  # type: ignore[arg-type]
    )
    perceiver = Perceiver(setup, configuration, trackers, Passes())  # type: ignore[arg-type]
    planner = create_planner(setup, configuration)
    hands = Gtsmc(load_gains("robust"), CAR, RATE_HZ)
    blank: Image = np.zeros((CAMERA.height_px, CAMERA.width_px, 3), np.uint8)
    steps = []
    for frame in frames:
        x, y, yaw = moved.pose(scene.pose(frame)).tolist()
        observation = Observation(blank, frame / RATE_HZ, x, y, wrap_angle(yaw), SPEED_MPS, 0.0, goal)
        perception = perceiver.perceive(observation)
        force, reference, extra = planner.step(perception, observation)
        plan = Plan(perception, force, perceiver.stop_when_blind(reference, observation), extra)
        steps.append((plan, hands.command(observation, plan.reference)))
    return steps


@pytest.mark.parametrize(("rate_hz", "every"), [(60.0, 3), (50.0, 2), (30.0, 1), (29.97, 1), (20.0, 1), (10.0, 1)])
def test_no_fewer_frames_are_looked_at_than_asked(rate_hz: float, every: int) -> None:
    setup = DriverSetup(CAMERA, CAR, rate_hz, SPEED_MPS, (200.0, 0.0), 5)
    assert Perceiver(setup, variant.load("robust")).frame_rate_hz == pytest.approx(rate_hz / every)


GOAL = np.array([200.0, 10.0])
STILL = Moved()


@pytest.fixture(scope="module")
def robust_steps() -> list[tuple[Plan, Command]]:
    return drive(variant.load("robust"), STILL, GOAL)


def test_the_body_is_found_and_passed_on_its_left(robust_steps: list[tuple[Plan, Command]]) -> None:
    plan, _ = robust_steps[-1]
    obstacles = plan.perception.obstacles
    assert len(obstacles) == 1
    gone = SPEED_MPS * (FRAMES - 1) / RATE_HZ
    assert obstacles.forward_m[0] == pytest.approx(20.0 - gone, abs=1.5)
    assert isinstance(plan.extra, LanePlan)
    assert plan.extra.cost.minimum_m < -0.4 - 0.95
    assert plan.perception.expansion.x_px == pytest.approx(319.5 - 320.0 * np.tan(radians(1.0)), abs=1.5)


def test_the_forces_add_up(robust_steps: list[tuple[Plan, Command]]) -> None:
    for plan, _ in robust_steps:
        force = plan.force
        assert force.total == pytest.approx(force.target + force.obstacle + force.road)


@pytest.mark.parametrize("name", ["robust", "paper"])
def test_turning_and_moving_the_world_changes_no_command(name: str) -> None:
    configuration = variant.load(name)
    there = drive(configuration, Moved(radians(137.0), (600.0, -800.0)), GOAL)
    for (_, here), (_, away) in zip(drive(configuration, STILL, GOAL), there, strict=True):
        assert away.steering == pytest.approx(here.steering, abs=1e-6)
        assert away.throttle == pytest.approx(here.throttle, abs=1e-6)


def test_the_mirror_image_steers_the_other_way(robust_steps: list[tuple[Plan, Command]]) -> None:
    robust = variant.load("robust")
    steered = 0.0
    for (_, here), (_, there) in zip(robust_steps, drive(robust, Moved(mirror=True), GOAL), strict=True):
        assert there.steering == pytest.approx(-here.steering, abs=1e-6)
        assert there.throttle == pytest.approx(here.throttle, abs=1e-6)
        steered = max(steered, abs(here.steering))
    assert steered > 0.05


def test_literal_is_not_equivariant() -> None:
    """The transposed rotation and the angle of the world make headings off the X axis special."""
    literal = variant.load("literal")
    (here, _), (away, _) = (drive(literal, moved, GOAL)[-1] for moved in (STILL, Moved(radians(30.0))))
    turn = wrap_angle(away.reference.heading_rad - here.reference.heading_rad)
    assert abs(wrap_angle(turn - radians(30.0))) > radians(10.0)


def test_the_obstacle_map_is_worked_out_once_where_it_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    requested = []
    detect = obstacles.detect
    monkeypatch.setattr(obstacles, "detect", lambda *given: requested.append(0) or detect(*given))
    seen = [plan.perception for plan, _ in drive(variant.load("robust"), STILL, GOAL)]
    assert not requested, "the lane planner goes by obstacles"
    assert (
        seen[-1].features.obstacle_map.on_obstacle.shape
        == seen[-1].features.ttc_s.shape
        == seen[-1].flow.points_px.shape[:1]
    )
    assert len(requested) == 1
