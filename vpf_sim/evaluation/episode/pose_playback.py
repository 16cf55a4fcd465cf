"""Playback of a stored episode: the environment with the car at the stored poses."""

from collections.abc import Sequence

import numpy as np

from vpf_sim.envs.four_lane import FourLane
from vpf_sim.evaluation.steps import StepTable
from vpf_sim.geometry import wrap_angle
from vpf_sim.types import Floats

RATES_HZ = (60.0, 20.0)
TOLERANCE = 1e-9  # m, rad, m/s: smaller deviations are not corrected


class PosePlayback(FourLane):
    """An environment that moves the car to the step table's pose after each step.

    The stored commands are applied, so actuators and sensors have the state of the episode. Where the resulting pose
    deviates, as with another version of the code, it is corrected; `largest_correction_m` is the largest correction.
    """

    def __init__(self, scenario: str, weather: str, table: StepTable, truth: Sequence[str] = ()) -> None:
        super().__init__(scenario, weather, rate_hz=rate_of(table), truth=truth)
        self._table, self._row = table, 0
        self.largest_correction_m = 0.0

    def advance(self, command: Floats) -> None:
        super().advance(command)
        self._row += 1
        position, yaw_rad = self._table.positions_m[self._row], float(self._table.yaw_rad[self._row])
        speed_mps = float(self._table.speed_mps[self._row])
        off_m = float(np.hypot(*(self.ego.position - position)))
        turn = wrap_angle(yaw_rad - self.ego.heading)
        if max(off_m, abs(turn), abs(speed_mps - self.ego.speed)) > TOLERANCE:
            self.largest_correction_m = max(self.largest_correction_m, off_m)
            self.ego.position, self.ego.speed = position.copy(), speed_mps
            self.ego.heading += turn
            self.ego.on_state_update()


def rate_of(table: StepTable) -> float:
    """The step rate of an episode, Hz."""
    measured = 1.0 / float(table.time_s[1] - table.time_s[0])
    return min(RATES_HZ, key=lambda rate: abs(rate - measured))
