"""The driver with the true scene."""

import numpy as np
import pytest

import vpf_sim
from vpf_sim import drivers
from vpf_sim.errors import InputError
from vpf_sim.types import Camera, DriverSetup, VehicleModel


@pytest.mark.parametrize("scenario", ["crossing", "roundabout-v0"])
def test_it_arrives_where_others_cross(scenario: str) -> None:
    """Of those who only keep their lane, as `idm` does, none gets through `crossing`."""
    record = vpf_sim.drive(scenario, driver="expert", seed=4).record
    assert record["status"] == "success"
    assert record["min_clearance_m"] > 0.2


@pytest.mark.slow
@pytest.mark.parametrize("scenario", ["stop-and-go", "rows", "exit-v0", "two-way-v0", "racetrack-v0", "u-turn-v0"])
def test_it_arrives(scenario: str) -> None:
    assert vpf_sim.drive(scenario, driver="expert", seed=4).status == "success"


def test_it_needs_the_world() -> None:
    driver = drivers.create("expert")
    with pytest.raises(InputError, match="driver expert: expected the world in its setup, got none"):
        driver.reset(DriverSetup(Camera(), VehicleModel(), 60.0, 5.55, (10.0, 0.0), 1, np.array([[0.0, 0], [9, 0]])))
