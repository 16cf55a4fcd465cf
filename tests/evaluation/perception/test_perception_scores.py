"""Metrics of a synthetic perception on a straight road with known errors."""

from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from perceived_road import LANE_M, RATE_HZ, SPEED_MPS, Report, Seen, Stands, drive, perfect, truth

from vpf_sim.cli.perception import print_differences, print_totals
from vpf_sim.errors import InputError
from vpf_sim.evaluation.perception import comparison, scores
from vpf_sim.evaluation.perception.store import Record
from vpf_sim.evaluation.truth.detections import Extent, near_end

BODIES = (
    Stands("car", 40.0, LANE_M + 2.5),
    Stands("cone", 60.0, LANE_M - 2.0),
    Stands("pallet", 70.0),
    Stands("van", 30.0, LANE_M - 1.0, speed_mps=1.0),
)
FRAMES = 100.0 / SPEED_MPS * RATE_HZ


def test_a_perfect_perception_has_recall_and_precision_1_and_no_error() -> None:
    found = scores.metrics([drive(BODIES, perfect(BODIES))])
    assert (found["recall"], found["precision"], found["false_positives_per_minute"]) == (1.0, 1.0, 0.0)
    assert (found["bodies_met"], found["edge_share"], found["lane_share"]) == (4, 1.0, 1.0)
    for key in scores.ERRORS:
        assert (found[key]["median"], found[key]["p95"]) == pytest.approx((0.0, 0.0), abs=1e-9), key


def test_known_errors_are_measured() -> None:
    def see(x_m: float, seconds: float) -> Seen:
        wrong = [
            replace(one, forward_m=one.forward_m + 0.3, left_m=one.left_m - 0.2, right_m=one.right_m - 0.1)
            for one in perfect(BODIES)(x_m, seconds).detections
        ]
        reported = [replace(one, speed_mps=one.speed_mps - 0.5) if one.speed_mps else one for one in wrong]
        return Seen(reported, left_m=0.05, right_m=-0.05, lane_m=0.02, foe_px=(3.0, -4.0))

    found = scores.metrics([drive(BODIES, see)])
    assert (found["recall"], found["precision"]) == (1.0, 1.0)
    made = {"distance_error_m": 0.3, "left_error_m": 0.2, "right_error_m": -0.1, "speed_error_mps": -0.5}
    for key, bias in {**made, "lane_error_m": 0.02}.items():
        assert (found[key]["median"], found[key]["p95"], found[key]["bias"]) == pytest.approx(
            (abs(bias), abs(bias), bias)
        )
    assert found["edge_error_m"]["median"] == pytest.approx(0.05)
    assert (found["foe_error_px"]["median"], found["foe_error_px"]["x"], found["foe_error_px"]["y"]) == (5.0, 3.0, 4.0)


def test_the_speed_of_a_static_object_detected_as_static_is_not_scored() -> None:
    still = (Stands("car", 40.0),)
    assert scores.metrics([drive(still, perfect(still))])["speed_error_mps"] is None

    def drives(x_m: float, seconds: float) -> Seen:
        return Seen([replace(one, speed_mps=2.0) for one in perfect(still)(x_m, seconds).detections])

    assert scores.metrics([drive(still, drives)])["speed_error_mps"]["bias"] == 2.0


def test_a_phantom_counts_once_as_false_positive_and_in_every_frame_for_precision() -> None:
    """20 s of driving; a phantom 20 m before the bumper for 10 frames, another 5 m before it for 30."""
    phantoms = {7: (20.0, range(10)), 8: (5.0, range(100, 130))}

    def see(_: float, seconds: float) -> Seen:
        row = round(seconds * RATE_HZ)
        reported = [Report(2.25 + m, -1.0, 1.0, identity=name) for name, (m, rows) in phantoms.items() if row in rows]
        return Seen(reported)

    found = scores.table([drive((), see)])
    (total,) = found["totals"]
    assert total["false_positives_per_minute"] == pytest.approx(2 / (20.0 / 60.0))
    assert (total["precision"], total["recall"], total["bodies_met"]) == (0.0, None, 0)
    by_band = {band["from_m"]: band["false_positives_per_minute"] for band in total["by_distance"]}
    assert by_band == pytest.approx({0.0: 3.0, 6.0: 0.0, 10.0: 0.0, 15.0: 3.0, 25.0: 0.0})


def test_precision_is_the_share_of_correct_detections_averaged_over_drives() -> None:
    car = (Stands("car", 90.0),)

    def half(x_m: float, seconds: float) -> Seen:
        return Seen([truth(car[0], x_m, seconds, 1), Report(10.0, -1.0, 1.0, identity=2)])

    drives = [drive(car, half, length_m=50.0), drive(car, perfect(car, 200.0), length_m=50.0, seed=1)]
    assert [scores.metrics([one])["precision"] for one in drives] == [0.5, 1.0]
    assert scores.metrics(drives)["precision"] == 0.75


def test_the_overlap_is_what_detection_and_object_share_of_what_either_covers() -> None:
    """A report half as wide as the van beside its middle, and one as wide that is shifted by half a width."""
    (van,) = vans = (Stands("van", 60.0),)

    def see(x_m: float, seconds: float, shift: float, width: float) -> Seen:
        one = truth(van, x_m, seconds, 1)
        left_m = one.left_m + shift * (one.right_m - one.left_m)
        return Seen([replace(one, left_m=left_m, right_m=left_m + width * (one.right_m - one.left_m))])

    for shift, width, overlap in ((0.0, 1.0, 1.0), (0.5, 0.5, 0.5), (0.5, 1.0, 1.0 / 3.0)):
        found = scores.metrics([drive(vans, partial(see, shift=shift, width=width), length_m=50.0)])
        assert found["overlap"] == pytest.approx(overlap), (shift, width)


def test_calibration_compares_the_stated_probability_with_the_share_that_exists() -> None:
    """A car that is stated with 95 % in each frame, and in every second one a phantom with 60 %, or with 95 %."""
    (car,) = cars = (Stands("car", 90.0),)

    def see(x_m: float, seconds: float, phantom: float) -> Seen:
        there = [replace(truth(car, x_m, seconds, 1), existence=0.95)]
        if round(seconds * RATE_HZ) % 2:
            there.append(Report(10.0, -1.0, 1.0, identity=2, existence=phantom))
        return Seen(there)

    frames = round(50.0 / SPEED_MPS * RATE_HZ)
    apart, together = (
        scores.metrics([drive(cars, partial(see, phantom=phantom), length_m=50.0)])["calibration"]
        for phantom in (0.6, 0.95)
    )
    assert [(row["stated"], row["right"], row["count"]) for row in apart] == [
        (pytest.approx(0.6), 0.0, frames // 2),
        (pytest.approx(0.95), 1.0, frames),
    ]
    ((share, count),) = [(row["right"], row["count"]) for row in together]
    assert (share, count) == (pytest.approx(2.0 / 3.0), frames + frames // 2)


def test_a_driver_that_states_no_probability_has_no_calibration() -> None:
    assert scores.metrics([drive(BODIES, perfect(BODIES))])["calibration"] == []


@pytest.mark.parametrize(
    ("bumper_m", "known"),
    [
        (15.3, {"car": 1.0, "cone": 1.0, "pallet": 1.0}),
        (14.9, {"car": 0.0, "cone": 1.0, "pallet": 1.0}),
        (9.9, {"car": 0.0, "cone": 0.0, "pallet": 1.0}),
        (5.9, {"car": 0.0, "cone": 0.0, "pallet": 0.0}),
    ],
)
def test_recall_is_at_the_due_distance_of_each_kind(bumper_m: float, known: dict[str, float]) -> None:
    bodies = (Stands("car", 40.0, LANE_M + 2.5), Stands("cone", 60.0), Stands("pallet", 80.0))
    (total,) = scores.table([drive(bodies, perfect(bodies, bumper_m + 2.25))])["totals"]
    assert {kind: row["recall"] for kind, row in total["by_kind"].items()} == known
    assert total["recall"] == pytest.approx(np.mean([*known.values()]))
    at_band = {band["from_m"]: band["recall"] for band in total["by_distance"]}
    assert at_band == {edge: float(bumper_m > edge) for edge in (0.0, 6.0, 10.0, 15.0, 25.0)}


def test_a_row_detected_as_one_has_the_sides_of_the_row() -> None:
    row = tuple(Stands("pedestrian", 50.0 + 0.2 * k, LANE_M + k - 1.0) for k in range(3))

    def see(x_m: float, _: float) -> Seen:
        return Seen([Report(50.0 - 0.2 - x_m, -1.25, 1.25)] if x_m < 47.0 else [])

    found = scores.metrics([drive(row, see)])
    assert (found["bodies_met"], found["recall"]) == (3, 1.0)
    for key in ("distance_error_m", "left_error_m", "right_error_m"):
        assert found[key]["p95"] == pytest.approx(0.0, abs=1e-9), key


def test_an_object_of_a_row_detected_alone_counts_alone() -> None:
    row = (Stands("car", 50.0, LANE_M - 1.5), Stands("cone", 50.0, LANE_M + 1.5))

    def see(x_m: float, seconds: float) -> Seen:
        car, cone = (truth(body, x_m, seconds, k) for k, body in enumerate(row))
        return Seen([replace(car, right_m=2.0), cone] if x_m < 45.0 else [])

    right_m = scores.metrics([drive(row, see)])["right_error_m"]
    assert right_m["p95"] == pytest.approx(2.0 + 0.5), "the car ends 0.5 m left of the ego's axis"


def test_an_undetected_road_has_no_error() -> None:
    def see(x_m: float, _: float) -> Seen:
        return Seen(lane_m=0.1, left_m=0.1, right_m=0.1, road=float(x_m < 25.0))

    found = scores.metrics([drive((), see)])
    assert (found["edge_share"], found["lane_share"]) == (0.25, 0.25)
    assert [found[key]["median"] for key in ("lane_error_m", "edge_error_m")] == pytest.approx([0.1, 0.1])


@pytest.mark.parametrize(
    ("turned_rad", "extent"),
    [
        (0.0, Extent(18.0, -1.0, 1.0)),
        (np.pi, Extent(18.0, -1.0, 1.0)),  # it comes towards the ego
        (0.3, Extent(20.0 - 2.0 * np.cos(0.3) - np.sin(0.3), -2.0 * np.sin(0.3) - np.cos(0.3), np.nan)),
    ],
)
def test_the_true_extent_of_an_object_is_its_end_towards_the_ego(turned_rad: float, extent: Extent) -> None:
    """A box of 4 x 2 m, 20 m ahead of an ego that looks along Y."""
    ego: Any = SimpleNamespace(position=np.array([5.0, 5.0]), heading=0.5 * np.pi, LENGTH=4.5, WIDTH=1.9)
    box: Any = SimpleNamespace(position=np.array([5.0, 25.0]), heading=0.5 * np.pi + turned_rad, LENGTH=4.0, WIDTH=2.0)
    found = near_end(box, ego)
    assert found[:2] == pytest.approx(extent[:2])
    assert found.right_m == pytest.approx(extent.right_m) or np.isnan(extent.right_m)


def test_the_tables_fit_a_page(capsys: pytest.CaptureFixture[str]) -> None:
    def see(x_m: float, seconds: float) -> Seen:
        reported = perfect(BODIES)(x_m, seconds).detections
        return Seen([replace(one, forward_m=one.forward_m + 0.1 * seconds) for one in reported], lane_m=0.01 * seconds)

    drives = [
        drive(BODIES, see, weather=weather, seed=seed, driver=driver)
        for weather in ("HardRainNoon", "clear")
        for seed in (0, 1)
        for driver in ("vpf", "vpf@movers")
    ]
    table = scores.table(drives)
    print_totals(table["totals"])
    print_differences(comparison.between_drivers([Record.model_validate(one) for one in table["records"]]))
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= 100, "\n".join(lines)
    assert sum(line.startswith("pallet") for line in lines) == 4, "each driver in each weather"


def records(*judgements: Any) -> list[Record]:
    return [Record.model_validate(scores.record(one)) for one in judgements]


def test_two_drivers_are_compared_on_the_same_drives_and_objects() -> None:
    bodies = (Stands("car", 60.0), Stands("cone", 80.0, LANE_M + 2.0))

    def off(error_m: float, sight_m: float) -> Any:
        def see(x_m: float, seconds: float) -> Seen:
            seen = perfect(bodies, sight_m)(x_m, seconds)
            return Seen([replace(one, forward_m=one.forward_m + error_m) for one in seen.detections])

        return see

    old = [drive(bodies, off(0.4, 14.0), seed=k, weather=w, driver="old") for k, w in ((0, "clear"), (1, "rain"))]
    new = [
        drive(bodies, off(0.4 - 0.1 * (k + 1), 60.0), seed=k, weather=w, driver="new")
        for k, w in ((0, "clear"), (1, "rain"))
    ]
    found = {row["weather"]: row for row in comparison.between_drivers(records(*old, *new))}
    assert set(found) == {"clear", "rain", "all"}
    row = found["all"]
    assert (row["driver"], row["minus"], row["drives"]) == ("new", "old", 2)
    assert row["distance_error_m"]["difference"] == pytest.approx(-0.15)
    assert (row["recall"]["difference"], row["recall"]["pairs"]) == (0.5, 4), "the car alone is known late"
    assert row["precision"]["difference"] == 0.0
    assert row["speed_error_mps"] is None
    assert found["rain"]["distance_error_m"]["difference"] == pytest.approx(-0.2)


def test_an_earlier_table_is_compared_where_the_poses_are_the_same() -> None:
    now = records(drive((), lambda *_: Seen(lane_m=0.1)), drive((), lambda *_: Seen(lane_m=0.1), seed=1))
    before = records(drive((), lambda *_: Seen(lane_m=0.3)), drive((), lambda *_: Seen(lane_m=0.3), seed=2))
    (row,) = comparison.between_versions(now, before, "old.json")
    assert (row["drives"], row["minus"]) == (1, "made-up in old.json")
    assert row["lane_error_m"]["difference"] == pytest.approx(-0.2)
    elsewhere = [one.model_copy(update={"states_sha256": "other"}) for one in before]
    with pytest.raises(InputError, match=r"old\.json: expected a drive with the same poses, got none of 2"):
        comparison.between_versions(now, elsewhere, "old.json")
    renamed = [one.model_copy(update={"driver": "vpf"}) for one in before]
    with pytest.raises(InputError, match=r"old\.json: expected what driver 'made-up' perceived, got only: vpf"):
        comparison.between_versions(now, renamed, "old.json")
