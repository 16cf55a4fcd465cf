"""The planner's settings, filled from spacetime.toml."""

from vpf_sim import configuration
from vpf_sim.configuration import setting, settings


@settings
class CandidateSettings:
    horizon_s: float = setting("Time that a candidate covers.", gt=0.0)
    step_s: float = setting("Time between the moments at which a candidate is judged.", gt=0.0)
    speed_shares: tuple[float, ...] = setting("End speeds, as shares of the reference speed.", min_length=1)
    settling_s: tuple[float, ...] = setting("Durations of the change to an end speed.", min_length=1)
    spacing_m: float = setting("Distance between the lateral end positions.", gt=0.0)
    most_positions: int = setting("Largest number of lateral end positions beside the lanes' middles.", ge=3)
    reach_s: tuple[float, ...] = setting(
        "Lengths of the way to an end position, as times at the present speed.", min_length=1
    )
    least_reach_m: tuple[float, ...] = setting(
        "Least lengths of the way to an end position, one for each time.", min_length=1
    )
    wait_s: tuple[float, ...] = setting("Times for which a car that drives straight may do so before it turns.")
    emergency_mps2: tuple[float, ...] = setting(
        "Decelerations of the stops that are always among the candidates.", min_length=1
    )


@settings
class LimitSettings:
    acceleration_mps2: float = setting("Largest acceleration.", gt=0.0)
    deceleration_mps2: float = setting("Largest deceleration.", gt=0.0)
    lateral_mps2: float = setting("Largest lateral acceleration.", gt=0.0)
    curvature_per_m: float = setting("Largest curvature of the rear axle's path.", gt=0.0)
    curvature_rate_per_ms: float = setting("Largest change of the curvature in a second.", gt=0.0)
    edge_m: float = setting("Least distance of the car's sides from the road's edges.", ge=0.0)
    along_m: float = setting("Least distance from an object along its heading.", ge=0.0)
    across_m: float = setting("Least distance from an object across its heading.", ge=0.0)
    occupied: float = setting("Probability above which a place counts as occupied.", gt=0.0, lt=0.5)


@settings
class CostSettings:
    speed: float = setting("Weight of the squared share of the reference speed that is lacking.", ge=0.0)
    acceleration: float = setting("Weight of the mean squared acceleration.", ge=0.0)
    lateral: float = setting("Weight of the mean squared lateral acceleration.", ge=0.0)
    lane: float = setting("Weight of the mean squared distance from the nearest lane's middle.", ge=0.0)
    route: float = setting("Weight of the mean distance from the route.", ge=0.0)
    lane_end: float = setting("Weight of the lacking time to leave a lane that ends.", ge=0.0)
    oncoming: float = setting("Weight of the mean width that the car covers of lanes of oncoming traffic.", ge=0.0)
    edge: float = setting("Weight of the nearness of the road's edges.", ge=0.0)
    edge_scale_m: float = setting("Distance in which the potential of an edge falls to its e-th part.", gt=0.0)
    near: float = setting("Weight of the nearness of objects.", ge=0.0)
    near_scale_m: float = setting("Distance in which the potential of an object falls to its e-th part.", gt=0.0)
    follow: float = setting("Weight of the squared lack of braking distance behind an object.", ge=0.0)
    time_gap: float = setting("Weight of the squared lack of a second's distance behind an object.", ge=0.0)
    change_side: float = setting(
        "Weight of the distance from the last plan's path, one second ahead, at least 4 m.", ge=0.0
    )
    change_speed: float = setting("Weight of another speed than in the last plan, one second ahead.", ge=0.0)


@settings
class SpacetimeSettings:
    candidates: CandidateSettings = setting("Motions that are compared.")
    limits: LimitSettings = setting("What a candidate must keep.")
    cost: CostSettings = setting("Weights of the potential field and of comfort.")

    def __post_init__(self) -> None:
        reach, least = self.candidates.reach_s, self.candidates.least_reach_m
        if len(reach) != len(least):
            raise ValueError(f"candidates.least_reach_m: expected {len(reach)} values as in reach_s, got {len(least)}")


def load() -> SpacetimeSettings:
    """The settings that are installed."""
    table = configuration.read("vpf_sim.planning.spacetime", "spacetime.toml")
    return configuration.build(SpacetimeSettings, table, "spacetime.toml")
