"""Playback of a stored episode: the environment with the car at the stored poses."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from hashlib import sha256

import numpy as np

from vpf_sim.envs.camera.weather import Weather
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.evaluation.environment import Info, Observed
from vpf_sim.evaluation.metrics.records import Record
from vpf_sim.evaluation.run_inputs import RunInputs
from vpf_sim.evaluation.steps import StepTable
from vpf_sim.geometry import wrap_angle
from vpf_sim.scenarios import AnyScenario
from vpf_sim.types import Floats

RATES_HZ = (60.0, 20.0)
TOLERANCE = 1e-9  # m, rad, m/s: smaller deviations are not corrected


@dataclass(frozen=True, slots=True)
class Played:
    """One frame of a playback: what `reset` or `step` returned."""

    index: int  # the row of the step table
    observed: Observed
    reward: float  # of the step before; 0 at the reset
    info: Info


class PosePlayback(FourLane):
    """An environment that moves the car to the step table's pose after each step.

    The stored commands are applied, so actuators and sensors have the state of the episode. Where the resulting pose
    deviates, as with another version of the code, it is corrected; `largest_correction_m` is the largest correction.
    """

    def __init__(
        self, scenario: str | AnyScenario, weather: str | Weather, table: StepTable, truth: Sequence[str] = ()
    ) -> None:
        super().__init__(scenario, weather, rate_hz=rate_of(table), truth=truth)
        self._table, self._row = table, 0
        self.largest_correction_m = 0.0
        self._frames_sha256 = ""

    @classmethod
    def of(cls, record: Record, table: StepTable, inputs: RunInputs, truth: Sequence[str] = ()) -> "PosePlayback":
        """The playback of a stored episode with the inputs of its run."""
        return cls(inputs.scenario(record.scenario), inputs.weather(record.weather), table, truth)

    def play(self, seed: int) -> Iterator[Played]:
        """Yield every frame of the episode in order, drawn with the stored commands and poses."""
        digest = sha256()
        observed, info = self.reset(seed=seed)
        reward = 0.0
        for index in range(len(self._table) + 1):
            if self._table.looked[index]:
                digest.update(np.ascontiguousarray(observed["image"]).data)
            yield Played(index, observed, reward, info)
            if index < len(self._table):
                command = np.array([self._table.throttle[index], self._table.steering[index]])
                observed, reward, _, _, info = self.step(command)
        self._frames_sha256 = digest.hexdigest()

    def has_frames_of(self, record: Record) -> bool:
        """Whether `play` drew the frames that the run's driver saw; True if it used none."""
        return record.frames_sha256 in (None, self._frames_sha256)

    def deviations(self, record: Record) -> list[str]:
        """How the episode that `play` drew differs from its record."""
        remarks = []
        if not self.has_frames_of(record):
            remarks.append("the frames differ from the run's: another version of the code, or another machine")
        if self.largest_correction_m > TOLERANCE:
            moved_m = self.largest_correction_m
            remarks.append(f"the car would now deviate by up to {moved_m:.2f} m; its stored poses are drawn")
        return remarks

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
