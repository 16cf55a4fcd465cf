"""The potential field without objects: target potential, road potential, and the cost of comfort.

The paper's fields with a third coordinate, time: a candidate's cost is the mean of the potentials along it.
"""

import numpy as np

from vpf_sim.planning.spacetime.candidates import PathState
from vpf_sim.planning.spacetime.limits import room_m
from vpf_sim.planning.spacetime.motions import Motions
from vpf_sim.planning.spacetime.settings import CostSettings
from vpf_sim.scene.road import Road
from vpf_sim.types import Bools, Reals

LEAST_REFERENCE_MPS = 0.1
END_SHARE = np.float32(0.5)
AHEAD_M, EVERY_M = 600.0, 4.0  # of the road beyond the horizon
LANE_CHANGE_S = 6.0  # wanted for each lane that has to be crossed before the lane ends
MOST_ONCOMING_M = 3.0


def field(cost: CostSettings, motions: Motions, leads: Bools, road: Road, reference_mps: float) -> dict[str, Reals]:
    """(P, M) each, by the potential's name; `leads`, which spreads to (P, M, T), is true where the path leads on."""
    return {
        "target": target(cost, motions, leads, road, reference_mps),
        "road": road_potential(cost, motions, road.overhang_m),
        "comfort": comfort(cost, motions),
    }


def target(cost: CostSettings, motions: Motions, leads: Bools, road: Road, reference_mps: float) -> Reals:
    """Speed that is lacking and distance from the route, both on the whole and at the end.

    Speed where the path does not lead on is as good as none.
    """
    reference = max(reference_mps, LEAST_REFERENCE_MPS)
    lacking = ((motions.speed_mps - np.float32(reference_mps)) / np.float32(reference)) ** 2
    lacking = np.where(leads, lacking, np.maximum(lacking, np.float32((reference_mps / reference) ** 2)))
    off = np.abs(motions.d_m - np.float32(road.route_m))
    return np.asarray(cost.speed * _whole_and_end(lacking) + cost.route * _whole_and_end(off), np.float32)


def _whole_and_end(values: Reals) -> Reals:
    """(P, M) mean in time, and half the last value, which stands for the time beyond the horizon."""
    whole: Reals = values.mean(axis=2) + END_SHARE * values[..., -1]
    return whole


def ending_lanes(cost: CostSettings, road: Road, start: PathState, width_m: float, ends_m: Reals) -> Reals:
    """(P,) cost of end positions that are off the road farther on: the share of the wanted time that is lacking."""
    ahead = np.arange(EVERY_M, AHEAD_M, EVERY_M)
    section = road.at(start.s_m + ahead)
    low, high = section.left_m + 0.5 * width_m, section.right_m - 0.5 * width_m
    shift = np.maximum(np.maximum(low - ends_m[:, None], ends_m[:, None] - high), 0.0) - road.overhang_m
    wanted_s = LANE_CHANGE_S * shift / road.lane_width_m
    lacking = 1.0 - ahead / max(start.speed_mps, LEAST_REFERENCE_MPS) / np.maximum(wanted_s, 1e-9)
    most: Reals = np.where(shift > 0.0, np.maximum(lacking, 0.0), 0.0).max(axis=1)
    return cost.lane_end * most


def road_potential(cost: CostSettings, motions: Motions, overhang_m: float) -> Reals:
    """Nearness of the edges, distance from the lanes' middles, and the width that is in oncoming lanes."""
    room = np.maximum(room_m(motions, overhang_m), 0.0)
    edges = cost.edge * np.exp(-room / np.float32(cost.edge_scale_m)).mean(axis=2)
    lanes = cost.lane * (motions.lane_offset_m**2).mean(axis=2)
    over = np.clip(motions.own_left_m - motions.leftmost_m, 0.0, MOST_ONCOMING_M)
    return np.asarray(edges + lanes + cost.oncoming * over.mean(axis=2), np.float32)


def comfort(cost: CostSettings, motions: Motions) -> Reals:
    """Mean squared accelerations."""
    lateral = motions.speed_mps**2 * motions.curvature_per_m
    along = (motions.acceleration_mps2**2).mean(axis=2)
    return np.asarray(cost.acceleration * along + cost.lateral * (lateral**2).mean(axis=2), np.float32)
