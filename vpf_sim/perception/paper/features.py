"""Obstacle map and time to contact of one frame, worked out when they are first read."""

from dataclasses import dataclass
from functools import cached_property

from vpf_sim.perception.egomotion.focus_of_expansion import Derotated
from vpf_sim.perception.paper import obstacle_map, time_to_contact
from vpf_sim.perception.paper.obstacle_region import Surroundings
from vpf_sim.perception.paper.paper_settings import ContactConfig, ObstacleMapConfig
from vpf_sim.types import Camera, Expansion, Floats, Flow, ObstacleMap, RoadEdges


@dataclass(frozen=True)
class FrameFeatures:
    """The point features of a frame: `obstacle_map`, the paper's O_t, and `ttc_s` (N,), inf where unknown."""

    flow: Flow
    steady_flow: Flow  # without the camera's pitch
    foe: Expansion
    derotated: Derotated
    road: RoadEdges
    speed_mps: float
    camera: Camera
    map_config: ObstacleMapConfig
    contact_config: ContactConfig

    @cached_property
    def obstacle_map(self) -> ObstacleMap:
        """The paper's O_t: the points that stand out, as a plane."""
        around = None
        if self.map_config.needs_surroundings:
            ttc_s = time_to_contact.time_to_contact(
                self.flow, self.foe, self.camera, self.contact_config, None, self.derotated
            )
            around = Surroundings(self.road, self.speed_mps, ttc_s)
        return obstacle_map.detect(self.steady_flow, self.camera, self.map_config, around)

    @cached_property
    def ttc_s(self) -> Floats:
        """(N,) time to contact of each point, by whole clusters of the map where the configuration says so."""
        labels = obstacle_map.cluster_labels(self.obstacle_map, self.flow)
        return time_to_contact.time_to_contact(
            self.flow, self.foe, self.camera, self.contact_config, labels, self.derotated
        )
