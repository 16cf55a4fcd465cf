"""How high the potentials across the lane are, how far they reach, and which bodies count (`lane.lateral_cost`)."""

from dataclasses import dataclass

MOST_CELLS = 10_000  # to one side


@dataclass(frozen=True, slots=True)
class LateralCostConfig:
    """Potentials have no unit; only their ratios matter."""

    reach_m: float  # of the grid, to both sides of the own lane's middle
    spacing_m: float
    target_per_m2: float  # k
    wall_height: float  # h_w
    wall_reach_m: float  # d_w
    edge_gap_m: float  # nearer to an edge no place is chosen, whatever stands on the road
    obstacle_height: float  # h_o
    obstacle_slope_per_m: float  # s_o
    unstopped_share: float  # by which both are more for a body too near for a stop, where no place is free
    tail_height: float  # h_t
    tail_decay_m: float  # d_t
    clearance_m: float  # c
    narrow_height: float  # h_n, more than the wall of an edge asks for where a gap is left beside a body
    narrow_m: float  # d_n
    row_height: float  # h_r
    row_gap_m: float  # b_r
    visible_m: float  # from here on a body counts, bumper to face
    full_m: float  # and from here on in full
    body_length_m: float  # a body counts until our rear is this far past its face,
    long_m: float  # one that moves, or may be a truck, until so far:
    truck_width_m: float  # from here on it may be one
    slower_mps: float  # than the reference speed is a body that moves and is overtaken
    beside_m: float  # others count only nearer than this: they are followed
    memory_height: float  # for leaving the surroundings of the last minimum
    memory_m: float  # how far these reach
    latch_m: float  # side latch of bodies nearer than this
    latch_height: float
    plan_height: float  # towards a narrow gap that the car does not go to yet
    beside_height: float  # of the latch while passing
    unreached_height: float  # of places that lie behind a body and cannot be reached before it

    def __post_init__(self) -> None:
        lengths = ("reach_m", "spacing_m", "wall_reach_m", "tail_decay_m", "memory_m", "narrow_m", "row_gap_m")
        for key in (*lengths, "target_per_m2"):
            if not getattr(self, key) > 0.0:
                raise ValueError(f"{key}: expected > 0, got {getattr(self, key)}")
        if self.reach_m / self.spacing_m > MOST_CELLS:
            raise ValueError(f"reach_m: expected at most {MOST_CELLS} times spacing_m, got {self.reach_m}")
        if not self.unstopped_share >= 0.0:
            raise ValueError(f"unstopped_share: expected >= 0, got {self.unstopped_share}")
        if not self.full_m < self.visible_m:
            raise ValueError(f"full_m: expected < visible_m = {self.visible_m}, got {self.full_m}")
