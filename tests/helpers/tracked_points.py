"""Tracks of standing points as a car sees them that drives by: what landmarks are made of."""

import numpy as np
from driver_settings import ROBUST, static_obstacles

from vpf_sim.geometry import project, vehicle_from_world
from vpf_sim.perception.obstacles.static_obstacle_settings import StaticObstacleConfig
from vpf_sim.perception.obstacles.static_tracker import StaticObstacleTracker
from vpf_sim.seeding import stream
from vpf_sim.types import Bools, Camera, Floats, Flow, Integers, Obstacles, RoadEdges

CAMERA = Camera()
RATE_HZ, SPEED_MPS = 60.0, 5.55
ANCHOR_FRAMES, WINDOW_PX = 42, ROBUST.flow.window_px
CORNER = 100.0 * np.eye(2)


def tracker(config: StaticObstacleConfig | None = None) -> StaticObstacleTracker:
    return StaticObstacleTracker(CAMERA, config or static_obstacles(), RATE_HZ, WINDOW_PX)


class Drive:
    """A car on the x axis, or on a circle, and standing points (N, 3), tracked while seen, with renewed anchors.

    Their structure tensors are (N, 2, 2), or one (2, 2) of all.
    """

    def __init__(
        self,
        scene_m: Floats,
        noise_px: float = 0.05,
        curvature_per_m: float = 0.0,
        structure: Floats = CORNER,
        speed_mps: float = SPEED_MPS,
    ) -> None:
        self.scene, self.noise_px, self.curvature, self.speed_mps = scene_m, noise_px, curvature_per_m, speed_mps
        self.structure = np.broadcast_to(structure, (len(scene_m), 2, 2))
        self.rng = stream(21, "landmarks")
        self.first_px = np.full((len(scene_m), 2), np.nan)
        self.first_pose = np.zeros((len(scene_m), 3))
        self.age = np.zeros(len(scene_m), np.int64)
        self.trail: list[tuple[Floats, Floats]] = []  # image points and pose of the last frames
        self.road = RoadEdges(-8.75, 5.25, 0.0, curvature_per_m, 0.02, 1.0, 0.0, 3.5)

    def pose(self, frame: int) -> Floats:
        way = frame * self.speed_mps / RATE_HZ
        if self.curvature == 0.0:
            return np.array([way, 0.0, 0.0])
        turn = way * self.curvature
        return np.array([np.sin(turn), 1.0 - np.cos(turn), turn * self.curvature]) / self.curvature

    def flow(self, frame: int) -> Flow:
        pose = self.pose(frame)
        place = vehicle_from_world(self.scene[:, :2], pose)
        seen = project(CAMERA, np.column_stack([place, self.scene[:, 2]]))
        seen = seen + self.rng.normal(0.0, self.noise_px, seen.shape)
        visible = (place[:, 0] > 2.0) & (place[:, 0] < 60.0) & np.all((seen > 5.0) & (seen < [634.0, 474.0]), axis=1)
        new = visible & np.isnan(self.first_px[:, 0])
        self.first_px[new], self.first_pose[new] = seen[new], pose
        self.age[visible & ~new] += 1
        self.trail = [*self.trail[-ANCHOR_FRAMES:], (seen, pose)]
        renewed = self.age >= 2 * ANCHOR_FRAMES
        self.first_px[renewed], self.first_pose[renewed] = self.trail[0][0][renewed], self.trail[0][1]
        self.age[renewed] = ANCHOR_FRAMES
        old = np.flatnonzero(visible & (self.age >= 6))
        past, past_pose = self.trail[max(0, len(self.trail) - 7)]
        count = len(old)
        return Flow(
            points_px=seen[old],
            displacement_px=seen[old] - past[old],
            gap_s=np.full(count, 0.1),
            past_pose=np.tile(past_pose, (count, 1)),
            pose=pose,
            identity=old.astype(np.int64),
            first_px=self.first_px[old],
            first_pose=self.first_pose[old],
            age_frames=self.age[old],
            structure=self.structure[old],
        )

    def run(self, tracker: StaticObstacleTracker, frames: range) -> list[Obstacles]:
        """The obstacles reported at each frame; no track slips, so each first observation is found where it is."""

        def match(rows: Integers, growth: Floats) -> tuple[Floats, Bools]:  # noqa: ARG001
            return np.zeros((len(rows), 2)), np.ones(len(rows), np.bool_)

        reported = []
        for frame in frames:
            flow = self.flow(frame)
            points = tracker.refined(flow, tracker.triangulate(flow), self.road, match, self.speed_mps)
            reported.append(tracker.update(flow, self.road, self.speed_mps, frame / RATE_HZ, points))
        return reported


class Traffic(Drive):
    """A drive along the x axis among points that move along it at a speed each."""

    def __init__(self, scene_m: Floats, speed_mps: Floats, noise_px: float = 0.05) -> None:
        super().__init__(scene_m, noise_px)
        self.start, self.speed = scene_m, speed_mps

    def flow(self, frame: int) -> Flow:
        self.scene = self.start.copy()
        self.scene[:, 0] += self.speed * frame / RATE_HZ
        return super().flow(frame)


def body(forward_m: float, right_m: float, width_m: float, height_m: float, count: int) -> Floats:
    rng = stream(22, f"body {forward_m}")
    across = right_m + width_m * np.linspace(-0.5, 0.5, count)
    return np.column_stack([np.full(count, forward_m), across, rng.uniform(0.3, height_m, count)])


def road_points(count: int, curvature_per_m: float = 0.0) -> Floats:
    rng = stream(23, "road")
    along, aside = rng.uniform(5.0, 120.0, count), rng.uniform(-8.0, 5.0, count)
    if curvature_per_m == 0.0:
        return np.column_stack([along, aside, np.zeros(count)])
    turn, radius = along * curvature_per_m, 1.0 / curvature_per_m
    return np.column_stack([(radius - aside) * np.sin(turn), radius - (radius - aside) * np.cos(turn), np.zeros(count)])
