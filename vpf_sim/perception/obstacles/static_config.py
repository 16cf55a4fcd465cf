"""When a followed point counts as standing above the road, and how many of them make a body."""

from dataclasses import dataclass, field

from vpf_sim.perception.egomotion.config import NoiseModel
from vpf_sim.perception.obstacles.free_road import FreeRoadConfig
from vpf_sim.perception.obstacles.looming_consistency import LoomingConsistencyConfig
from vpf_sim.perception.obstacles.low_obstacles import LowObstacleConfig
from vpf_sim.perception.obstacles.planar_parallax.config import LowTrackConfig, ParallaxConfig
from vpf_sim.perception.obstacles.track_refinement import RefinementConfig
from vpf_sim.perception.road.config import OcclusionConfig


@dataclass(frozen=True, slots=True)
class StaticObstacleConfig:
    """Limits and time constants of `vpf_sim.perception.obstacles.static_tracker.StaticObstacleTracker`."""

    residual: ParallaxConfig
    spots: LowTrackConfig
    update_period_s: float = 0.05  # between judgements of the points
    window_px: int = 11  # of the flow, for the noise of a track
    grey_levels: float = 5.0  # noise of a track, see NoiseModel
    floor_px: float = 0.1
    growth_s: float = 0.17
    anisotropy: float = 0.04
    pitch_rad: float = 0.0005
    min_age_s: float = 0.05
    way_share: float = 0.06  # of the depth, that the car has gone since: on less, water on the glass looks near
    chi2_limit: float = 9.0  # of a point against its own depth
    chi2_margin: float = 20.0  # by which the road must fit worse
    depth_ratio: float = 0.10  # largest sigma_Z / Z
    min_height_m: float = 0.2
    max_height_m: float = 1.8
    near_m: float = 2.5  # range of depth in which points are judged
    far_m: float = 28.0
    turned_near_m: float = 6.5  # where it begins while the car is turned from the road by more than turned_rad:
    turned_rad: float = 0.3  # what is near shows its flank then
    hits_s: float = 0.13  # a point is believed after so long,
    hits_share: float = 0.5  # if it stood above the road in this share of the frames since it first did
    steady_m: float = 0.1  # and its place in the world changed by no more than this, plus
    steady_ratio: float = 0.04  # this share of the depth
    single_hits_s: float = 0.3  # and one alone after so long,
    single_depth_ratio: tuple[float, float] = (0.035, 0.07)  # known so well or so badly
    single_min_height_m: tuple[float, float] = (0.35, 0.45)  # at such a height: ends of dashes seem to stand 0.3 m high
    single_max_height_m: float = 1.1
    single_far_m: float = 14.0
    recent_px: float = 0.3  # largest error of the motion in the last window, plus
    recent_ratio: float = 0.05  # this share of its length
    edge_margin_m: float = 0.3  # inside the carriageway's edges
    edge_line_m: float = 0.4  # points whose foot lies so near the edge line inside,
    verge_m: float = 1.8  # and so near outside, are not trusted
    corner_texture: float = 60.0  # unless so clear a corner (small eigenvalue, grey levels^2 / px^2)
    corner_ratio: float = 0.25  # that is no less than this share of the large one: edges have .2
    founding_texture: float = 33.0  # smaller ones found no body: where puddles end and what they mirror begins slides
    dash_far_m: float = 14.0  # nor do points farther than this
    dash_height_m: float = 0.45  # and lower than this whose ray meets the road on a line: ends of dashes slide there
    foot_m: float = 45.0  # points whose ray meets the road farther away found no body: bends of lines slide there,
    high_share: float = 0.5  # but corners so clear as to be trusted beside an edge line count for so much of one
    link_right_m: float = 1.0  # points nearer than this belong to one body
    link_forward_m: float = 2.0
    face_sigma_m: float = 0.5  # a body is told once its face is known so well
    told_m: float = 21.0  # and so near, from the pose: depth errs with the square of the distance
    sharp_side_m: float = 0.12  # points with a smaller sigma across count for the sides, or those near the best
    outdated_share: float = 0.75  # parts come nearer to than this share of their depth, and not seen again, are none
    beside_m: float = 0.05  # each side is told so much farther out than its points tell
    least_width_m: float = 0.4  # a body is told no narrower: a cone's flow comes from its stripes, its base is wider
    behind_m: float = 11.0  # where a body is forgotten
    low: LowObstacleConfig = field(default_factory=LowObstacleConfig)
    cover: OcclusionConfig = field(default_factory=OcclusionConfig)
    spread: LoomingConsistencyConfig = field(default_factory=LoomingConsistencyConfig)
    clearing: FreeRoadConfig = field(default_factory=FreeRoadConfig)
    asked: RefinementConfig = field(default_factory=RefinementConfig)

    def __post_init__(self) -> None:
        if not 0.0 < self.near_m < self.far_m:
            raise ValueError(f"near_m, far_m: expected 0 < near < far, got {self.near_m}, {self.far_m}")
        if not self.near_m <= self.turned_near_m < self.far_m:
            raise ValueError(f"turned_near_m: expected near_m <= it < far_m, got {self.turned_near_m}")
        if self.min_height_m >= self.max_height_m:
            raise ValueError(f"min_height_m: expected < max_height_m, got {self.min_height_m}")
        for key in ("single_depth_ratio", "single_min_height_m"):
            if not 0.0 < getattr(self, key)[0] < getattr(self, key)[1]:
                raise ValueError(f"{key}: expected 0 < first < second, got {getattr(self, key)}")
        if not 0.0 <= self.high_share < 1.0:
            raise ValueError(f"high_share: expected 0 .. 1, 1 left out, got {self.high_share}")
        if not 0.0 <= self.outdated_share < 1.0:
            raise ValueError(f"outdated_share: expected 0 .. 1, 1 left out, got {self.outdated_share}")
        if not self.way_share >= 0.0:
            raise ValueError(f"way_share: expected >= 0, got {self.way_share}")
        if not self.least_width_m >= 0.0:
            raise ValueError(f"least_width_m: expected >= 0, got {self.least_width_m}")

    @property
    def noise(self) -> NoiseModel:
        return NoiseModel(self.grey_levels, self.floor_px, self.growth_s, self.anisotropy, self.pitch_rad)
