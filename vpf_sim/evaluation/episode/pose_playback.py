"""The world of a stored episode, in which the car is where its steps say: it takes no decision to see it again."""

from collections.abc import Sequence

import numpy as np

from vpf_sim.envs.four_lane import FourLane
from vpf_sim.evaluation.steps import StepTable
from vpf_sim.geometry import wrap_angle
from vpf_sim.types import Floats

RATES_HZ = (60.0, 20.0)
SAME = 1e-9  # m, rad, m/s: less than this is no other place


class PosePlayback(FourLane):
    """A scenario's world, in which the car is after each step where the step table says.

    The stored commands are applied, so that actuators and sensors are in the state of the episode; where that leads
    elsewhere, as under another version of the code, the car is moved. `moved_m` is the farthest that it had to be.
    """

    def __init__(self, scenario: str, weather: str, table: StepTable, truth: Sequence[str] = ()) -> None:
        super().__init__(scenario, weather, rate_hz=rate_of(table), truth=truth)
        self._table, self._row = table, 0
        self.moved_m = 0.0

    def advance(self, command: Floats) -> None:
        super().advance(command)
        self._row += 1
        place, yaw_rad = self._table.positions_m[self._row], float(self._table.yaw_rad[self._row])
        speed_mps = float(self._table.speed_mps[self._row])
        off_m = float(np.hypot(*(self.ego.position - place)))
        turn = wrap_angle(yaw_rad - self.ego.heading)
        if max(off_m, abs(turn), abs(speed_mps - self.ego.speed)) > SAME:
            self.moved_m = max(self.moved_m, off_m)
            self.ego.position, self.ego.speed = place.copy(), speed_mps
            self.ego.heading += turn
            self.ego.on_state_update()


def rate_of(table: StepTable) -> float:
    """The clock of the episode, Hz."""
    measured = 1.0 / float(table.time_s[1] - table.time_s[0])
    return min(RATES_HZ, key=lambda rate: abs(rate - measured))
