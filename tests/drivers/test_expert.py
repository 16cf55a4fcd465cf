"""The driver with the true scene."""

from pathlib import Path

import numpy as np
import pytest

import vpf_sim
from vpf_sim import drivers
from vpf_sim.driver_interface import DriverSetup
from vpf_sim.errors import InputError
from vpf_sim.types import Camera, VehicleModel

STANDING = """schema = 1
[road]
lanes = 3
segments = [{{kind = "line", length_m = 60}}]
[ego]
lane = 2
s_m = 10.0
speed_mps = 0.0
[goal]
s_m = 40.0
[[bodies]]
kind = "car"
s_m = {parked_m}
lane = 2
"""


@pytest.fixture(scope="module")
def crossing() -> vpf_sim.Episode:
    """Of those who only keep their lane, as `idm` does, none gets through."""
    return vpf_sim.drive("crossing", driver="expert", seed=4)


def test_it_arrives_where_others_cross(crossing: vpf_sim.Episode) -> None:
    for record in (crossing.record, vpf_sim.drive("roundabout-v0", driver="expert", seed=4).record):
        assert record["status"] == "success"
        assert record["min_clearance_m"] > 0.2


def test_each_frame_records_the_motion_and_why_others_were_rejected(crossing: vpf_sim.Episode) -> None:
    steps = crossing.steps
    driven = steps[steps.throttle.notna()]
    assert driven.filter(regex="^(motion|rejected)_").notna().all(axis=None)
    near = driven.clearance_m < 6.0
    assert driven.rejected_collision[near].max() > 0 == driven.rejected_collision[driven.clearance_m > 60.0].sum()
    soon = np.interp(driven.time_s + 1.0, driven.time_s, driven.speed_mps)
    before_end = driven.time_s < driven.time_s.iloc[-1] - 1.0
    assert np.median(np.abs(soon - driven.motion_1s_mps)[before_end]) < 0.2


@pytest.mark.slow
@pytest.mark.parametrize("scenario", ["stop-and-go", "rows", "exit-v0", "two-way-v0", "racetrack-v0", "u-turn-v0"])
def test_it_arrives(scenario: str) -> None:
    assert vpf_sim.drive(scenario, driver="expert", seed=4).status == "success"


def test_it_needs_the_world() -> None:
    driver = drivers.create("expert")
    with pytest.raises(InputError, match="driver expert: expected the world in its setup, got none"):
        driver.reset(DriverSetup(Camera(), VehicleModel(), 60.0, 5.55, (10.0, 0.0), 1, np.array([[0.0, 0], [9, 0]])))


@pytest.mark.parametrize("gap_m", [2.8, 4.0])
def test_it_drives_past_a_car_before_which_it_stands(gap_m: float, tmp_path: Path) -> None:
    """The parked car is 5 m long; what is planned while the wheels turn must be what the car then does."""
    file = tmp_path / "standing.toml"
    file.write_text(STANDING.format(parked_m=10.0 + 0.5 * (4.5 + 5.0) + gap_m))
    record = vpf_sim.drive(file, driver="expert").record
    assert record["status"] == "success"
    assert record["min_clearance_m"] > 0.1
