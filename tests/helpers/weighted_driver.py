"""A driver with one weight, which is no part of its code, as that of a network."""

import os

import vpf_sim

WEIGHT = "VPF_SIM_TEST_WEIGHT"  # environment variable


class Weighted(vpf_sim.Driver):
    """Steers by its weight times the time."""

    sees = False

    def reset(self, setup: vpf_sim.DriverSetup) -> None:  # noqa: ARG002
        self._weight = float(os.environ.get(WEIGHT, "0.01"))

    def act(self, observation: vpf_sim.Observation) -> vpf_sim.Command:
        return vpf_sim.Command(0.1, self._weight * observation.time_s)
