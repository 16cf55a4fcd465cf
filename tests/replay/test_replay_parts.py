"""Parts of a replay without images: segments, model vehicle, present lane, table, checks."""

from dataclasses import replace
from math import atan, inf, sin, tan
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from vpf_sim.controllers.gtsmc import load_gains
from vpf_sim.driver_interface import Observation
from vpf_sim.replay import drive_record, obstacles_ahead, real_table, scores
from vpf_sim.replay.frame_table import FrameRow, FrameTable
from vpf_sim.replay.model_vehicle import Interval, ModelVehicle, segments
from vpf_sim.replay.present_lane import is_found, obstacles_in_vehicle_frame, present_lane, road_in_vehicle_frame
from vpf_sim.replay.recording import Frame, Origin, Recording
from vpf_sim.replay.records import Accuracies, Both, LanePart, Row, SignalOrigin
from vpf_sim.types import Camera, Floats, Obstacles, Reference, RoadEdges, VehicleModel

VEHICLE = VehicleModel()


def recording(seconds: float, rate_hz: float = 10.0, **changes: Any) -> Recording:
    """Straight ahead at 10 m/s, without images."""
    times = np.arange(round(seconds * rate_hz)) / rate_hz
    poses = np.stack([10.0 * times, 0.0 * times, 0.0 * times], axis=1)
    names = ("poses", "speed_mps", "yaw_rate_radps", "steering_rad", "throttle")
    values: dict[str, Any] = {
        "name": "straight",
        "layout": "made up",
        "camera": Camera(),
        "times_s": times,
        "poses": poses,
        "speed_mps": 10.0 + times,
        "yaw_rate_radps": 0.0 * times,
        "frames": lambda: iter([Frame(k, None, "none") for k in range(len(times))]),
        "origins": dict.fromkeys(names, Origin("recorded")),
    }
    return Recording(**{**values, **changes})


def test_segments_are_equal_parts_of_at_most_twenty_seconds() -> None:
    found = segments(recording(50.0))
    assert [(part.first, part.stop) for part in found] == [(0, 167), (167, 334), (334, 500)]
    assert found[1].speed_mps == pytest.approx(26.7)
    assert found[1].goal_m == pytest.approx((333.0, 0.0))


def test_goal_without_poses_is_a_hundred_metres_ahead() -> None:
    drive = recording(10.0)
    turned = replace(drive.origins["poses"], kind="absent")
    found = segments(replace(drive, origins={**drive.origins, "poses": turned}))
    assert found[0].goal_m == (100.0, 0.0)


def observed(yaw_rad: float, speed_mps: float) -> Observation:
    return Observation(np.zeros((0, 0, 3), np.uint8), 0.0, 0.0, 0.0, yaw_rad, speed_mps, 0.0, (0.0, 0.0))


@pytest.mark.parametrize(("rate_hz", "speed_mps"), [(10.0, 25.0), (25.0, 8.0)])
def test_model_vehicle_steers_the_requested_bend(rate_hz: float, speed_mps: float) -> None:
    """Camera rates at which the controller alone would oscillate."""
    radius = 80.0
    model, rate = ModelVehicle(load_gains("motion"), VEHICLE, rate_hz), speed_mps / radius
    model.restart(speed_mps)
    said = []
    for k in range(round(4.0 * rate_hz)):
        poses = [np.array([0.0, 0.0, rate * (k + i) / rate_hz]) for i in (0, 1)]
        poses[1][:2] = speed_mps / rate_hz, 0.0
        wanted = Reference(float(poses[0][2]), speed_mps, rate)
        interval = Interval(poses[0], poses[1], 1.0 / rate_hz)
        said.append(model.drive(wanted, observed(float(poses[0][2]), speed_mps), interval))
    slip = np.arcsin(VEHICLE.l_r_m / radius)
    known = atan(VEHICLE.wheelbase_m / VEHICLE.l_r_m * tan(slip)) / VEHICLE.steering_limit_rad
    assert [command.steering for command in said[-5:]] == pytest.approx([known] * 5, rel=0.03)
    assert [command.throttle for command in said] == pytest.approx([0.0] * len(said))


def test_model_vehicle_has_its_own_speed() -> None:
    model = ModelVehicle(load_gains("motion"), VEHICLE, 10.0)
    model.restart(10.0)
    still = Interval(np.zeros(3), np.zeros(3), 0.1)  # the recorded car at standstill
    for _ in range(30):
        model.drive(Reference(0.0, 8.0, 0.0), observed(0.0, 0.0), still)
    assert model.speed_mps == pytest.approx(8.0, abs=0.2)
    assert model.right_m == 0.0


def test_wheels_are_held_while_the_recorded_car_stands() -> None:
    """The throttle command has no effect on the recording."""
    model = ModelVehicle(load_gains("motion"), VEHICLE, 20.0)
    model.restart(0.0)
    still = Interval(np.zeros(3), np.zeros(3), 0.05)
    said = [model.drive(Reference(0.2, 5.5, 0.0), observed(0.0, 0.0), still) for _ in range(40)]
    assert [command.steering for command in said] == [0.0] * 40


def test_model_vehicle_restarts_at_the_recorded_speed() -> None:
    model = ModelVehicle(load_gains("motion"), VEHICLE, 20.0)
    for speed_mps in (2.0, 12.0):
        model.restart(speed_mps)
        ahead = Interval(np.zeros(3), np.array([speed_mps / 20.0, 0.0, 0.0]), 0.05)
        said = [model.drive(Reference(0.0, speed_mps, 0.0), observed(0.0, speed_mps), ahead) for _ in range(10)]
        assert [command.throttle for command in said] == pytest.approx([0.0] * 10)


ROAD = RoadEdges(-8.0, 6.0, 0.02, 0.0, 0.05, 0.9, 4.5, 3.5, 0.9)


def test_present_lane_is_nearest_to_the_car() -> None:
    lane = present_lane(ROAD, found=True)
    assert lane.lane_m == pytest.approx(1.0)
    assert (lane.left_m, lane.right_m, lane.heading_rad) == (-8.0, 6.0, 0.02)
    beyond = present_lane(replace(ROAD, right_m=0.5), found=True)
    assert beyond.right_m == pytest.approx(2.75), "what is driven on is road"


def test_missing_lane_lies_straight_ahead_whatever_the_edges() -> None:
    """A left edge to the right of the car would pull the model car to the right repeatedly."""
    for road in (ROAD, replace(ROAD, left_m=1.9, right_m=15.9, lane_m=-0.5)):
        lane = present_lane(road, found=False)
        assert (lane.lane_m, lane.heading_rad, lane.curvature_per_m, lane.confidence) == (0.0, 0.0, 0.0, 0.0)
        assert (lane.left_m, lane.right_m) == (-7.0, 7.0)


@pytest.mark.parametrize(
    ("changes", "speed_mps", "found"),
    [
        ({}, 20.0, True),
        ({"heading_rad": 0.1}, 20.0, False),  # 2 m/s to the side
        ({"lane_confidence": 0.4}, 20.0, False),
        ({"curvature_per_m": 0.03}, 10.0, True),
        ({"curvature_per_m": 0.03}, 25.0, False),  # 19 m/s2 to the side
        ({"curvature_per_m": -0.03}, 0.0, False),  # the outline of a car ahead
        ({}, 0.0, True),
    ],
)
def test_lane_is_rejected_where_no_car_could_drive_it(changes: dict[str, float], speed_mps: float, found: bool) -> None:
    assert is_found(replace(ROAD, **changes), speed_mps) == found


def test_frames_without_a_lane_are_not_scored() -> None:
    rows = [
        FrameRow(k, k / 10.0, 0, 1.0, 5.0, 0.0, 0.0, 0.1, 0.0, np.nan, throttle=0.0, steering=0.1, road_found=1.0)
        for k in range(20)
    ]
    lost = [row._replace(road_found=0.0, throttle=-1.0, steering=-1.0) if row.frame >= 12 else row for row in rows]
    found = scores.accuracies(FrameTable.of(lost), recording(2.0))
    assert found is not None
    assert (found.steering.mae, found.throttle.mae) == (0.0, 0.0)
    assert found.frames.whole == 12
    assert found.lane.not_found == LanePart(frames=8, steering=None, idle=None)
    nowhere = scores.accuracies(FrameTable.of([row._replace(road_found=0.0) for row in rows]), recording(2.0))
    assert nowhere is not None
    assert (nowhere.steering, nowhere.frames.whole) == (None, 0)


def test_road_and_obstacles_are_in_the_model_vehicle_frame() -> None:
    road = road_in_vehicle_frame(ROAD, 1.5, 0.05)
    assert (road.lane_m, road.left_m, road.heading_rad) == (3.0, -9.5, pytest.approx(-0.03))
    one = np.array([20.0])
    obstacles = Obstacles(one, np.array([0.5]), np.array([2.5]), one, one, np.array([1]))
    moved = obstacles_in_vehicle_frame(obstacles, 1.5, 0.05)
    assert 0.5 * (moved.left_m + moved.right_m) == pytest.approx([-20.0 * sin(0.05)])
    assert moved.right_m - moved.left_m == pytest.approx([2.0])


def record(name: str, weather: str, throttle: str = "recorded", added: str | None = None, mae: float = 0.1) -> Any:
    """The record of an empty drive, with these origins and scores."""
    drive, table = recording(1.0), FrameTable.of([])
    replayed = SimpleNamespace(protocol="", restarts=0, unlike_training=lambda: "")
    empty = drive_record.of(replace(drive, weather=weather), "vpf", replayed, table, drive_record.Accumulated(), None)
    one = {"range": 1.0 - mae / 2.0, "span": None, "tolerance": 1.0, "mae": mae}
    both, none = {"throttle": one, "steering": one}, {"throttle": None, "steering": None}
    parts = {**both, "clear_of_obstacles": both, "with_obstacles": none}
    count = 10 if mae < 0.2 else 30
    frames, unseen = ({"whole": n, "clear_of_obstacles": n, "with_obstacles": 0} for n in (count, count // 2))
    lane = {key: {"frames": 0, "steering": None, "idle": None} for key in ("found", "not_found")}
    accuracy = {**parts, "frames": frames, "unseen": unseen, "idle": parts, "lane": lane}
    kinds = {"throttle": throttle, "steering_rad": "recorded"}
    changes = {
        "name": name,
        "added": added,
        "obstacles_by": "label",
        "origins": {signal: SignalOrigin(kind=kind, how="") for signal, kind in kinds.items()},
        "accuracy": Accuracies.model_validate(accuracy),
    }
    return empty.model_copy(update=changes)


def filled(records: list[Any]) -> list[Row]:
    return [row for row in real_table.summary(records).rows if row.frames]


def test_drives_are_weighted_by_their_frames() -> None:
    (row,) = filled([record("a", "Overcast"), record("b", "cloudy", mae=0.3)])
    assert (row.weather, row.drives, row.frames, row.unseen) == ("cloudy", ("a", "b"), 40, 20)
    assert row.accuracy.throttle.mae == pytest.approx((10 * 0.1 + 30 * 0.3) / 40)
    assert row.paper == Both[float](throttle=0.6943, steering=0.6492)


def test_derived_and_simulated_signals_have_their_own_rows() -> None:
    mixed = [record("a", "rain"), record("b", "rain", "derived"), record("c", "rain", added="simulated water")]
    found = {(row.signals.throttle, row.added): row for row in filled(mixed)}
    assert set(found) == {("recorded", None), ("derived", None), ("recorded", "simulated water")}
    assert found["recorded", "simulated water"].paper is None


def test_paper_cells_without_a_drive_remain() -> None:
    cells = [(row.weather, row.part) for row in real_table.summary([record("a", "sunny")]).rows if row.paper]
    assert cells == list(real_table.PAPER)


def test_flickering_detection_starts_no_part() -> None:
    detected: Floats = np.zeros(40)
    detected[10] = 1.0
    detected[20:30] = 1.0
    assert np.flatnonzero(obstacles_ahead.persistent(detected, 10.0)).tolist() == list(range(20, 30))


def test_drive_shorter_than_persistence_is_one_part() -> None:
    for count in (2, 20, 24, 25, 26):
        assert obstacles_ahead.persistent(np.ones(count), 25.0).tolist() == [1.0] * count
        assert obstacles_ahead.persistent(np.zeros(count), 25.0).tolist() == [0.0] * count


def test_closing_speed_is_the_slope_of_the_gap() -> None:
    times = np.arange(20) / 10.0
    gap = 12.0 - 2.0 * times
    closing = obstacles_ahead.closing_mps(gap, times)
    assert closing == pytest.approx(np.full(20, 2.0))
    assert obstacles_ahead.true_ttc_s(gap, closing)[[0, 10]] == pytest.approx([6.0, 5.0])
    assert obstacles_ahead.true_ttc_s(gap, -closing)[0] == inf


def test_ttc_is_scored_where_the_gap_closes() -> None:
    rows = [FrameRow(k, k / 10.0, 0, 1.0, 5.0, 0.0, 0.0, 0.0, 0.0, 12.0 - 0.2 * k) for k in range(20)]
    table = FrameTable.of(rows)
    true = table.lead_gap_m / 2.0
    found = scores.time_to_contact(table.replaced("ttc_s", np.where(table.frame < 10, 1.1, 1.5) * true))
    assert found is not None
    assert (found.frames, found.seen, found.within_25_percent) == (20, 1.0, 0.5)
    assert found.median_error == pytest.approx(0.3)


def test_inverted_steering_sign_gives_negative_gain() -> None:
    rate = 0.1 * np.sin(np.arange(100) / 10.0)
    drive = recording(10.0)
    steering = np.arctan(VEHICLE.wheelbase_m * rate / drive.speed_mps)
    for sign in (1.0, -1.0):
        checked = scores.signal_checks(replace(drive, yaw_rate_radps=rate, steering_rad=sign * steering))
        assert checked.yaw_rate.gain == pytest.approx(sign)
