"""What the stages of a pipeline hand on: one record, filled while a frame is processed."""

from dataclasses import dataclass, field

from vpf_sim.driver_interface import Observation
from vpf_sim.perception.egomotion.focus_of_expansion import Derotated
from vpf_sim.perception.egomotion.triangulation import Triangulation
from vpf_sim.perception.obstacles.crossing import Crossers, nobody
from vpf_sim.perception.obstacles.point_motion import PointMotions
from vpf_sim.perception.obstacles.prediction import none
from vpf_sim.types import (
    UNLIMITED,
    Bools,
    Expansion,
    Floats,
    Flow,
    Image,
    LowObstacleRange,
    Obstacles,
    PointFeatures,
    RoadEdges,
)


@dataclass(slots=True)
class FrameState:
    """Inputs of a frame, results of its stages, and feedback, which the next frame reads.

    Before a frame, the last frame's `obstacles` are moved to its axes.
    """

    # Inputs
    observation: Observation = field(init=False)  # of the moment at which the frame was taken
    pose: Floats = field(init=False)  # (3,) x m, y m, yaw rad of the vehicle then
    gap_s: float = field(init=False)  # since the frame before
    late: float = field(init=False)  # share of a period by which the frame was taken after its turn

    # Egomotion
    grey: Image = field(init=False)  # (H, W)
    flow: Flow = field(init=False)
    derotated: Derotated = field(init=False)
    foe: Expansion | None = None  # feedback: prior of the next frame's
    steady_flow: Flow = field(init=False)  # without the camera's pitch
    pitch_change_rad: float = 0.0  # + looks farther down than in the last frame

    # Road
    road: RoadEdges = field(init=False)
    road_pitch: tuple[float, float] | None = None  # rad and its standard deviation, from the road's lines

    # Obstacles
    points: Triangulation | None = None  # of the flow, in the robust pipeline
    on_moving: Bools | None = None  # (N,) points of the flow on moving obstacles
    motions: PointMotions | None = None  # of the points of the flow, where actors that cross are looked for
    crossers: Crossers = field(default_factory=nobody)
    obstacles: Obstacles = field(default_factory=none)  # feedback: they hide the road in the next frame
    relief: Floats | None = None  # (K,) of the obstacles, by planar parallax
    low_range_m: LowObstacleRange = UNLIMITED

    # The paper's fields
    features: PointFeatures = field(init=False)
