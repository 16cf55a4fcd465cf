"""Measures of a replayed drive that need no labels, so that a recording and its twin are measured alike."""

from dataclasses import astuple, dataclass, fields
from math import nan
from typing import Self

import numpy as np

from vpf_sim.replay.frame_table import FrameTable
from vpf_sim.types import Bools, Floats

BRAKING = -0.1  # throttle below which the driver demands braking
LEAD_M = 1.5  # an object in the own lane that is this near to the true gap is the lead vehicle


@dataclass(frozen=True, slots=True)
class Measures:
    """Means over the frames that the driver saw; shares in %, nan where there is nothing to measure."""

    objects: float  # reported in a frame
    standing: float  # those that do not move
    in_lane: float  # in the own lane
    on_line: float  # on a line of the own lane
    wide: float  # wider than a vehicle
    braking: float  # %, frames in which the driver demands braking
    lead: float  # %, frames with an object at the true gap to the lead vehicle, of those with a true gap
    lead_error: float  # m, median of |reported - true gap| in these
    lane: float  # %, frames with a lane
    lane_width: float  # m, median
    lane_spread: float  # m, interquartile range of the lane's lateral position
    foe_x: float  # px, interquartile range of the focus of expansion
    foe_y: float
    held: float  # %, frames with an unreliable flow
    flow: float  # median number of points

    @classmethod
    def of(cls, table: FrameTable) -> Self:
        """The measures of a replayed drive."""
        seen = FrameTable(table.rows[table.image == 1.0])
        with_gap = np.isfinite(seen.lead_gap_m)
        error_m = np.abs(seen.nearest_in_lane_m - seen.lead_gap_m)[with_gap]
        is_lead = error_m < LEAD_M
        return cls(
            objects=_mean(seen.obstacles),
            standing=_mean(seen.obstacles_standing),
            in_lane=_mean(seen.obstacles_in_lane),
            on_line=_mean(seen.obstacles_on_line),
            wide=_mean(seen.obstacles_wide),
            braking=100.0 * _mean(seen.throttle < BRAKING),
            lead=100.0 * _mean(is_lead),
            lead_error=_median(error_m[is_lead]),
            lane=100.0 * _mean(seen.road_found),
            lane_width=_median(seen.lane_width_m),
            lane_spread=_range(seen.lane_m),
            foe_x=_range(seen.foe_x_px),
            foe_y=_range(seen.foe_y_px),
            held=100.0 * _mean(seen.held),
            flow=_median(seen.flow_points),
        )

    @classmethod
    def mean(cls, parts: list[Self]) -> Self:
        """The mean of each measure over those parts that have it."""
        columns = np.array([astuple(part) for part in parts]).T
        return cls(*(_mean(column) for column in columns))

    def rows(self, twin: Self) -> list[dict[str, float | str]]:
        """A row a measure, with the recording's value and the twin's."""
        return [
            {"measure": item.name, "recorded": _shown(self, item.name), "twin": _shown(twin, item.name)}
            for item in fields(self)
        ]


def _shown(measures: Measures, name: str) -> float | str:
    value: float = getattr(measures, name)
    return value if np.isfinite(value) else "-"


def _finite(values: Floats) -> Floats:
    return values[np.isfinite(values)]


def _mean(values: Floats | Bools) -> float:
    finite = _finite(np.asarray(values, float))
    return float(np.mean(finite)) if len(finite) else nan


def _median(values: Floats) -> float:
    finite = _finite(values)
    return float(np.median(finite)) if len(finite) else nan


def _range(values: Floats) -> float:
    finite = _finite(values)
    return float(np.subtract(*np.percentile(finite, [75.0, 25.0]))) if len(finite) else nan
