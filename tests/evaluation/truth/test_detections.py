"""Detections against true objects, on a straight road with known distances."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from perceived_road import Thing

from vpf_sim.envs.contacts import nearest
from vpf_sim.envs.road import Carriageway
from vpf_sim.evaluation.metrics import perception
from vpf_sim.evaluation.metrics.perception import KINDS
from vpf_sim.evaluation.steps import Step, StepTable
from vpf_sim.evaluation.truth.detections import DetectionScorer
from vpf_sim.evaluation.truth.surroundings import free_width_m
from vpf_sim.scenarios.parts import Road
from vpf_sim.types import Obstacles

LENGTH_M = 4.5
NONE: dict[str, float] = {"objects_right": 0, "objects_wrong": 0, "new_wrong_objects": 0}


@pytest.fixture
def road() -> Any:
    """A straight along X, its carriageway's centre at y = 0."""
    straight = Road.model_validate({"start_m": [0.0, 0.0], "segments": [{"kind": "line", "length_m": 300.0}]})
    return SimpleNamespace(network=Carriageway(straight), vehicles=[], objects=[])


def box(road: Any, x: float, y: float, length: float = 5.0, width: float = 2.0, kind: str = "car") -> Any:
    return Thing(position=np.array([x, y]), heading=0.0, LENGTH=length, WIDTH=width, place=(x, y), kind=kind, road=road)


def detections(*feet: tuple[float, float], identity: int = 1) -> Obstacles:
    """Objects 2 m wide whose nearest face is at (forward, right)."""
    forward, right = np.array(feet, float).reshape(-1, 2).T
    some = np.ones(len(feet))
    return Obstacles(forward, right - 1.0, right + 1.0, some, some, np.arange(identity, identity + len(feet)))


def world(ego: Any) -> Any:
    return SimpleNamespace(ego=ego, road=ego.road, nearest=nearest(ego))


def columns(scorer: DetectionScorer, road: Any, x: float, reported: Obstacles) -> dict[str, float]:
    return scorer.columns(reported, world(box(road, x, 0.0, LENGTH_M, 1.9)))


@pytest.mark.parametrize(
    ("foot", "right", "wrong"),
    [
        ((37.5, 0.0), 1, 0),  # the face of the car at 40 m
        ((36.1, 0.0), 1, 0),
        ((35.9, 0.0), 0, 1),  # 1.6 m before it
        ((43.9, 0.0), 1, 0),
        ((44.1, 0.0), 0, 1),  # 1.6 m behind it
        ((40.0, 2.4), 1, 0),
        ((40.0, -2.6), 0, 1),  # 1.6 m beside it
        ((20.0, 2.9), 0, 1),
        ((20.0, 3.1), 0, 0),  # not in the corridor
        ((2.2, 0.0), 0, 0),  # under the bonnet
        ((-8.0, 0.0), 0, 0),
    ],
)
def test_a_detection_is_correct_if_its_foot_is_within_a_metre_and_a_half(
    road: Any, foot: tuple[float, float], right: int, wrong: int
) -> None:
    road.objects.append(box(road, 140.0, 0.0))
    found = columns(DetectionScorer(), road, 100.0, detections(foot))
    assert (found["objects_right"], found["objects_wrong"], found["new_wrong_objects"]) == (right, wrong, wrong)


def test_the_corridor_turns_with_the_road_and_not_with_the_car(road: Any) -> None:
    ego = box(road, 100.0, 0.0, LENGTH_M, 1.9)
    ego.heading = 0.3
    found = DetectionScorer().columns(detections((20.0, -20.0 * np.tan(0.3))), world(ego))
    assert found["objects_wrong"] == 1, "straight ahead along the road"
    assert DetectionScorer().columns(detections((20.0, 0.0)), world(ego))["objects_wrong"] == 0, "5.9 m to the right"


def test_a_false_positive_is_new_once(road: Any) -> None:
    scorer = DetectionScorer()
    seen = [columns(scorer, road, x, detections((20.0, 0.0), identity=i)) for x, i in ((0.0, 7), (1.0, 7), (2.0, 8))]
    assert [found["new_wrong_objects"] for found in seen] == [1, 0, 1]
    assert [found["objects_wrong"] for found in seen] == [1, 1, 1]


def test_an_object_is_met_once_with_its_first_confirmation_distance(road: Any) -> None:
    road.objects += [box(road, 140.0, 0.5), box(road, 140.0, -4.0), box(road, 170.1, 0.0, 0.4, 0.4, "cone")]
    scorer, met = DetectionScorer(), []
    for x in np.arange(100.0, 180.0, 0.25):
        seen = detections((137.5 - x, 0.5)) if 118.0 <= x <= 121.0 else detections()
        found = columns(scorer, road, x, seen)
        if np.isfinite(found["met_kind"]):
            met.append((x, KINDS[int(found["met_kind"])], found["met_confirmed_m"]))
    gap_m = 140.0 - 118.0 - 0.5 * (5.0 + LENGTH_M)
    assert met[0] == (135.0, "car", gap_m), "0.25 m before the bumper touches the face's line"
    assert met[1][:2] == (167.5, "cone")
    assert np.isnan(met[1][2])
    assert len(met) == 2, "the car at 4 m aside is not in the corridor"


def test_an_object_detected_from_the_next_lane_is_confirmed(road: Any) -> None:
    road.objects.append(box(road, 40.0, 4.0))
    scorer = DetectionScorer()
    far = columns(scorer, road, 10.0, detections((37.5 - 10.0, 4.0)))
    assert (far["objects_right"], far["objects_wrong"]) == (0, 0), "4 m aside it is not in the corridor"
    met = [scorer.columns(detections(), world(box(road, x, 2.0, LENGTH_M, 1.9))) for x in (30.0, 35.2)]
    assert met[-1]["met_confirmed_m"] == 40.0 - 10.0 - 0.5 * (5.0 + LENGTH_M)


@pytest.mark.parametrize(
    ("face", "left", "right", "known"),
    [
        (20.0, -4.5, 4.5, [True, True, True]),
        (20.0, -4.5, 1.4, [True, True, False]),  # to the side of the one in the middle
        (18.1, -4.5, 4.5, [False, False, False]),  # 1.7 m before the first
        (21.8, -4.5, 4.5, [False, True, True]),  # 1.6 m behind it
        (20.0, 2.4, 4.5, [False, False, True]),
        (20.0, -10.9, 1.0, [False, False, False]),  # its middle is 1.7 m beside the first, so it is wrong
    ],
)
def test_a_row_detected_as_one_is_confirmed_behind_its_face(
    road: Any, face: float, left: float, right: float, known: list[bool]
) -> None:
    road.objects += [box(road, 120.0 + 0.2 * i, 3.0 * (i - 1), 0.4, 0.5, "pedestrian") for i in range(3)]
    some = np.ones(1)
    seen = Obstacles(np.array([face]), np.array([left]), np.array([right]), some, some, np.ones(1, np.int64))
    scorer, met = DetectionScorer(), []
    for x in np.arange(100.0, 122.0, 0.1):
        found = columns(scorer, road, x, seen if x == 100.0 else detections())
        if np.isfinite(found["met_kind"]):
            met.append(bool(np.isfinite(found["met_confirmed_m"])))
    assert met == known


def test_two_objects_met_at_once_are_recorded_one_after_the_other(road: Any) -> None:
    road.objects += [box(road, 10.0, 1.5, 0.4, 0.4, "cone"), box(road, 10.0, -1.5, 0.8, 0.8, "pallet")]
    scorer = DetectionScorer()
    kinds = [columns(scorer, road, x, detections())["met_kind"] for x in (0.0, 7.6, 7.7, 7.8)]
    assert [KINDS[int(kind)] for kind in kinds[1:3]] == ["cone", "pallet"]
    assert np.isnan([kinds[0], kinds[3]]).all()


def test_no_detections_and_no_objects(road: Any) -> None:
    found = columns(DetectionScorer(), road, 10.0, detections())
    assert {key: found[key] for key in NONE} == NONE
    assert np.isnan([found["met_kind"], found["met_confirmed_m"]]).all()


def table(*rows: dict[str, float]) -> StepTable:
    """One row every 10 s, and the one that ends it."""
    rows = (*rows, {})
    return StepTable.of([Step(10.0 * k, *[0.0] * 7, np.inf, **row) for k, row in enumerate(rows)])


def test_detection_metrics() -> None:
    car, cone = float(KINDS.index("car")), float(KINDS.index("cone"))
    scores = perception.objects(
        table(
            {"objects_right": 3, "objects_wrong": 0, "new_wrong_objects": 0, "met_kind": car, "met_confirmed_m": 15.0},
            {"objects_right": 3, "objects_wrong": 1, "new_wrong_objects": 1, "met_kind": car, "met_confirmed_m": 14.9},
            {"objects_right": 0, "objects_wrong": 1, "new_wrong_objects": 0, "met_kind": cone, "met_confirmed_m": 10.1},
            {"objects_right": 0, "objects_wrong": 0, "new_wrong_objects": 0, "met_kind": cone},
        )
    )
    assert scores == {
        "met": 4,
        "confirmed": 3,
        "first_confirmed_m": 14.9,
        "recall": 0.5,
        "precision": 0.75,
        "wrong_per_minute": pytest.approx(1.5),
    }


def test_a_driver_without_a_plan_has_no_detection_metrics() -> None:
    assert perception.objects(table({})) is None
    empty = perception.objects(table({**NONE}))
    assert empty is not None
    assert (empty["met"], empty["recall"], empty["precision"], empty["wrong_per_minute"]) == (0, None, None, 0.0)


@pytest.mark.parametrize(
    ("feet", "sticks_out_m"),
    [
        ([(37.5, 0.0)], 0.0),  # 2 m wide, as the car
        ([(37.5, 0.4)], 0.4),  # its left side
        ([(37.5, -0.7)], 0.7),
        ([(38.0, 0.0)], 0.5),  # nearer than reported
        ([(36.5, 0.0)], 0.0),
        ([(37.5, 0.6), (37.5, -0.6)], 0.0),  # both together cover it
        ([(20.0, 0.0)], np.nan),
        ([], np.nan),
    ],
)
def test_what_sticks_out_of_a_detection(road: Any, feet: list[tuple[float, float]], sticks_out_m: float) -> None:
    road.objects.append(box(road, 140.0, 0.0))
    found = columns(DetectionScorer(), road, 100.0, detections(*feet))
    assert found["near_sticks_out_m"] == pytest.approx(sticks_out_m, nan_ok=True)


def test_the_nearest_object_keeps_its_first_confirmation(road: Any) -> None:
    road.objects.append(box(road, 140.0, 0.0))
    scorer = DetectionScorer()
    assert np.isnan(columns(scorer, road, 100.0, detections())["near_confirmed_m"])
    first_m = 140.0 - 2.5 - 110.0 - 0.5 * LENGTH_M
    assert columns(scorer, road, 110.0, detections((27.5, 0.0)))["near_confirmed_m"] == pytest.approx(first_m)
    assert columns(scorer, road, 130.0, detections())["near_confirmed_m"] == pytest.approx(first_m)


def test_the_nearest_false_positive_ahead(road: Any) -> None:
    road.objects.append(box(road, 140.0, 0.0))
    reported = detections((37.5, 0.0), (24.0, 1.0), (12.0, -1.0), (8.0, 5.0))
    assert columns(DetectionScorer(), road, 100.0, reported)["wrong_ahead_m"] == pytest.approx(12.0 - 0.5 * LENGTH_M)
    assert np.isnan(columns(DetectionScorer(), road, 100.0, detections((37.5, 0.0)))["wrong_ahead_m"])


@pytest.mark.parametrize(
    ("bodies", "free_m"),
    [
        ([], 14.0),
        ([(110.0, 0.0)], 6.0),
        ([(110.0, 0.0), (112.0, 4.0)], 6.0),
        ([(110.0, -3.0), (112.0, 3.0)], 4.0),
        ([(110.0, -3.5), (112.0, -1.5), (111.0, 3.0)], 7.0 - 4.0),
        ([(120.0, 0.0)], 14.0),  # farther
        ([(96.0, 0.0)], 14.0),  # behind
        ([(110.0, y) for y in (-6.0, -3.0, 0.0, 3.0, 6.0)], 1.0),
    ],
)
def test_the_widest_gap_across_the_road(road: Any, bodies: list[tuple[float, float]], free_m: float) -> None:
    """On a carriageway of 14 m, before a car at x = 100."""
    others = [box(road, *place) for place in bodies]
    ego = box(road, 100.0, 0.0, LENGTH_M, 1.9)
    assert free_width_m(ego, others, road.network) == pytest.approx(free_m)


def test_a_turned_object_takes_more_width(road: Any) -> None:
    ego, other = box(road, 100.0, 0.0, LENGTH_M, 1.9), box(road, 110.0, 0.0)
    other.heading = np.pi / 2.0
    assert free_width_m(ego, [other], road.network) == pytest.approx(7.0 - 2.5)
