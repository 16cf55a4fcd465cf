"""The benchmark: the grid of the paper's simulator table, and the printed values."""

from vpf_sim.evaluation.sweeps.plan import Plan

SCENARIOS = ("town04-clean", "town04")
WEATHERS = ("clear", "rain")
DRIVERS = ("vpf", "vpf-paper", "vpf-literal", "pid")
SEEDS = "1000:1030"
# Table "Simulator results", rows "Cloudy" (set-up: Clear Noon) and "Rain" (set-up: Hard Rain): throttle and steering
# accuracy with respect to the PID, without a definition, and the mean squared error of the path, with its unit as m.
PAPER: dict[tuple[str, str], dict[str, float]] = {
    ("town04-clean", "clear"): {"throttle": 0.8234, "steering": 0.7214, "path_mse_m2": 0.42},
    ("town04", "clear"): {"throttle": 0.7851, "steering": 0.7167, "path_mse_m2": 0.74},
    ("town04-clean", "rain"): {"throttle": 0.7845, "steering": 0.6712, "path_mse_m2": 0.97},
    ("town04", "rain"): {"throttle": 0.7076, "steering": 0.6545, "path_mse_m2": 1.34},
}


def plan(seeds: str | None, drivers: list[str]) -> Plan:
    """The benchmark's plan, for the given drivers or all."""
    return Plan(SCENARIOS, WEATHERS, tuple(drivers) or DRIVERS, seeds or SEEDS)
