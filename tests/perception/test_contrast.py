"""What is coloured stands out from grey: against luma + R - B without saturation on the way, then on a drawn road."""

from dataclasses import replace

import numpy as np
import pytest
from plated_road import CAMERA, PLATE_M, frame

from vpf_sim.driver_interface import DriverSetup, Observation
from vpf_sim.drivers.paper_pipeline import FrameTrackers
from vpf_sim.drivers.perceiver import Perceiver
from vpf_sim.perception.contrast import contrast
from vpf_sim.perception.egomotion.flow import grey
from vpf_sim.planning import variant
from vpf_sim.seeding import stream
from vpf_sim.types import RoadEdges, VehicleModel

LOOKS_HZ, SPEED_MPS, HEIGHT_M = 10.0, 5.55, 0.15


def test_red_is_added_and_blue_taken_off_and_grey_stays() -> None:
    image = stream(1, "colours").integers(0, 256, (48, 64, 3)).astype(np.uint8)
    image[0] = image[0, :, :1]
    luma = grey(image)
    expected = luma.astype(int) + image[..., 0].astype(int) - image[..., 2].astype(int)
    assert np.array_equal(contrast(image, luma), np.clip(expected, 0, 255))


@pytest.mark.parametrize("colour", [(140, 105, 60), (200, 90, 40), (190, 40, 45)], ids=["wood", "orange", "red"])
def test_what_is_as_bright_as_the_road_is_seen_by_its_colour(colour: tuple[int, int, int]) -> None:
    image = np.empty((4, 2, 3), np.uint8)
    image[:, 0] = colour
    image[:, 1] = round(float(np.dot(colour, [0.299, 0.587, 0.114])))
    luma = grey(image)
    assert np.ptp(luma.astype(int)) <= 1
    assert np.ptp(contrast(image, luma)[0].astype(int)) > 60


class Straight:
    """Stands in for the road's tracker."""

    pitch = None

    def update(self, *_: object) -> RoadEdges:
        return RoadEdges(-7.0, 7.0, 0.0, 0.0, 0.05, 1.0, 0.0, 3.5)

    def turn(self, down_rad: float) -> None:
        pass


@pytest.mark.parametrize(("colour", "bodies"), [((122, 90, 52), 1), ((95, 95, 95), 0)], ids=["wood", "grey"])
def test_the_driver_tells_a_plate_as_bright_as_the_road_by_its_colour(
    colour: tuple[int, int, int], bodies: int
) -> None:
    """Where the plate is grey as well nothing shows it but its edges, from nearer by."""
    setup = DriverSetup(CAMERA, VehicleModel(), LOOKS_HZ, SPEED_MPS, (200.0, 0.0), 5)
    robust = variant.load("robust")
    trackers = replace(FrameTrackers.create(setup, robust, LOOKS_HZ), road=Straight())  # type: ignore[arg-type]
    perceiver = Perceiver(setup, robust, trackers)
    for step, forward in enumerate(np.arange(10.0, 22.0, SPEED_MPS / LOOKS_HZ).tolist()):
        image = np.stack([frame(forward, HEIGHT_M, plate_level=level) for level in colour], axis=-1)
        observation = Observation(image, step / LOOKS_HZ, forward, 0.0, 0.0, SPEED_MPS, 0.0, (200.0, 0.0))
        told = perceiver.perceive(observation).obstacles
    assert len(told) == bodies
    if bodies:
        assert told.forward_m[0] + forward == pytest.approx(PLATE_M[0, 0], abs=1.1)
        assert (told.left_m[0], told.right_m[0]) == pytest.approx(tuple(PLATE_M[:, 1]), abs=0.5)
