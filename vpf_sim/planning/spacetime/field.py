"""The potential field without objects: target potential, road potential, and the cost of comfort.

The paper's fields with a third coordinate, time: a candidate's cost is the mean of the potentials along it.
"""

import numpy as np

from vpf_sim.planning.spacetime.candidates import PathState, Profiles
from vpf_sim.planning.spacetime.limits import room_m
from vpf_sim.planning.spacetime.motions import Motions
from vpf_sim.planning.spacetime.settings import CostSettings
from vpf_sim.planning.spacetime.way import leads_on
from vpf_sim.scene.road import Road
from vpf_sim.types import Reals

LEAST_REFERENCE_MPS = 0.1
END_SHARE = np.float32(0.5)
AHEAD_M, EVERY_M = 600.0, 4.0  # of the road beyond the horizon
LANE_CHANGE_S = 6.0  # wanted for each lane that has to be crossed before the lane ends
MOST_ONCOMING_M = 3.0


def field(
    cost: CostSettings, motions: Motions, ways_m: Reals, profiles: Profiles, road: Road, reference_mps: float
) -> dict[str, Reals]:
    """(P, M) each, by the potential's name; `ways_m` (P,) is how far the paths lead."""
    return {
        "speed": speed(cost, profiles, ways_m, reference_mps),
        "route": route(cost, motions, road.route_m),
        "road": road_potential(cost, motions, road.overhang_m),
        "comfort": comfort(cost, motions),
    }


def speed(cost: CostSettings, profiles: Profiles, ways_m: Reals, reference_mps: float) -> Reals:
    """Target potential along the road: speed that is lacking, on the whole and at the end.

    Speed where the path does not lead on is as good as none.
    """
    distinct, path = np.unique(ways_m, return_inverse=True)
    reference = max(reference_mps, LEAST_REFERENCE_MPS)
    lacking = ((profiles.speed_mps - reference_mps) / reference) ** 2
    lacking = np.where(leads_on(distinct, profiles), lacking, np.maximum(lacking, (reference_mps / reference) ** 2))
    found: Reals = cost.speed * (lacking.mean(axis=2) + END_SHARE * lacking[..., -1])
    return found[path].astype(np.float32)


def route(cost: CostSettings, motions: Motions, route_m: float) -> Reals:
    """Target potential across the road: distance from the route, on the whole and at the end."""
    off = np.abs(motions.d_m - np.float32(route_m))
    found: Reals = np.float32(cost.route) * (motions.mean(off) + END_SHARE * motions.last(off))
    return found


def ending_lanes(cost: CostSettings, road: Road, start: PathState, width_m: float, ends_m: Reals) -> Reals:
    """(P,) cost of end positions that are off the road farther on: the share of the wanted time that is lacking."""
    ahead = np.arange(EVERY_M, AHEAD_M, EVERY_M)
    section = road.at(start.s_m + ahead)
    low, high = section.left_m + 0.5 * width_m, section.right_m - 0.5 * width_m
    found, paths = np.zeros(len(ends_m)), np.flatnonzero((ends_m < low.max()) | (ends_m > high.min()))
    ends = ends_m[paths, None]
    shift = np.maximum(np.maximum(low - ends, ends - high), 0.0) - road.overhang_m
    wanted_s = LANE_CHANGE_S * shift / road.lane_width_m
    lacking = 1.0 - ahead / max(start.speed_mps, LEAST_REFERENCE_MPS) / np.maximum(wanted_s, 1e-9)
    found[paths] = cost.lane_end * np.where(shift > 0.0, np.maximum(lacking, 0.0), 0.0).max(axis=1)
    return found


def road_potential(cost: CostSettings, motions: Motions, overhang_m: float) -> Reals:
    """Nearness of the edges, distance from the lanes' middles, and the width that is in oncoming lanes."""
    room = np.maximum(room_m(motions, overhang_m), 0.0)
    potential = np.float32(cost.edge) * np.exp(-room / np.float32(cost.edge_scale_m))
    potential += np.float32(cost.lane) * motions.lane_offset_m**2
    potential += np.float32(cost.oncoming) * np.clip(motions.own_left_m - motions.leftmost_m, 0.0, MOST_ONCOMING_M)
    return motions.mean(potential)


def comfort(cost: CostSettings, motions: Motions) -> Reals:
    """Mean squared accelerations."""
    along = (motions.acceleration_mps2**2).mean(axis=1)
    lateral = motions.mean(motions.curvature_per_m**2, motions.speed_mps**4)
    found: Reals = np.float32(cost.acceleration) * along + np.float32(cost.lateral) * lateral
    return found
