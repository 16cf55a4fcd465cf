"""The baselines in the environment itself: what each reaches, and what it does about bodies in its way."""

import numpy as np
import pytest
from blind import drive_blind

CLEAN = ("straight", "curve-left", "curve-right", "heading-30", "town04-clean")


@pytest.mark.parametrize("scenario", CLEAN)
@pytest.mark.parametrize(("name", "most_m2"), [("pure-pursuit", 0.002), ("stanley", 0.002), ("idm", 0.04)])
def test_on_empty_roads_they_reach_the_goal_on_their_lane(name: str, most_m2: float, scenario: str) -> None:
    driven = drive_blind(scenario, name, seed=7)
    assert driven.status == "success"
    assert np.mean(driven.offset_m**2) < most_m2
    assert np.percentile(np.abs(np.diff(driven.steering)), 95) < 0.01


@pytest.mark.parametrize("name", ["pure-pursuit", "stanley"])
def test_they_know_no_obstacles(name: str) -> None:
    assert drive_blind("town04", name, seed=7).status == "collision"


@pytest.mark.parametrize(
    ("scenario", "seed", "status"),
    [("town04", 3, "stuck"), ("town04", 11, "success"), ("traffic", 3, "success"), ("blocked", 3, "success")],
)
def test_idm_passes_or_stops_behind_what_is_there(scenario: str, seed: int, status: str) -> None:
    """Whether it passes the second car of town04 hangs on where the seed puts it: MOBIL looks one lane far."""
    assert drive_blind(scenario, "idm", seed).status == status
