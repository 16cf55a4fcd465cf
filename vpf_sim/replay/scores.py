"""Scores of a replayed driver: commands beside the human's, perception against ground truth."""

from collections.abc import Callable
from typing import Any

import numpy as np

from vpf_sim.evaluation.metrics.tracking import Accuracy, accuracy
from vpf_sim.replay.frame_table import FrameTable
from vpf_sim.replay.obstacles_ahead import closing_mps, persistent, true_ttc_s
from vpf_sim.replay.recording import IMAGES, Origin, Recording
from vpf_sim.types import Bools, Floats

PARTS = ("clear_of_obstacles", "with_obstacles")
SIGNALS = ("throttle", "steering")
NAMES = {"throttle": "throttle", "steering": "steering_rad"}  # their names in a recording
LEAST_CLOSING_MPS = 0.5  # least closing speed for comparing the time to contact
STANDING_MPS = 0.3  # of car and gap: nothing approaches
LEAST_SPEED_MPS = 2.0  # least speed for comparing it
ALARM_S = 4.0  # time to contact that calls for braking
LEAST_SPAN = 0.005  # least span of a signal for the span accuracy
DIGITS = 6  # of stored scores


def accuracies(table: FrameTable, recording: Recording) -> dict[str, Any] | None:
    """Accuracy of throttle and steering, overall and with and without obstacles; None if not driven.

    Frames without a lane are not scored, nor is an assumed signal or one that follows from it. `idle` is the accuracy
    of zero commands, `frames` the number of scored frames of each part, `unseen` those of them without a new image or
    command.
    """
    recorded = {"throttle": table.recorded_throttle, "steering": table.recorded_steering}
    driven = {name: np.isfinite(getattr(table, name)) for name in SIGNALS}
    if not any(there.any() for there in driven.values()):
        return None
    recorded_known = {
        name: np.isfinite(values) & recording.origins[NAMES[name]].is_known for name, values in recorded.items()
    }
    has_lane = _has_lane(table)
    known = {name: recorded_known[name] & driven[name] & has_lane for name in SIGNALS}
    parts, blind = part_masks(table, recording.rate_hz), unseen(table)

    def scores(mask: Bools | None, idle: bool) -> dict[str, Accuracy | None]:
        return {
            name: None if mask is None else _accuracy(table, name, recorded[name], known[name] & mask, idle)
            for name in SIGNALS
        }

    whole = np.ones(len(table), np.bool_)
    masks = {"whole": whole, **parts}
    return {
        **scores(whole, False),
        **{part: scores(parts[part], False) for part in PARTS},
        "frames": {name: None if mask is None else int((mask & has_lane).sum()) for name, mask in masks.items()},
        "unseen": {
            name: None if mask is None else int((mask & has_lane & blind).sum()) for name, mask in masks.items()
        },
        "idle": {**scores(whole, True), **{part: scores(parts[part], True) for part in PARTS}},
        "lane": {name: _steering_beside_idle(scores, mask) for name, mask in _lane_masks(table).items()},
    }


def notes(table: FrameTable, recording: Recording) -> list[str]:
    """Notes that a reader of the scores needs, one line each."""
    if not np.isfinite(table.throttle).any():
        return []
    lines: list[str] = []
    count = len(table)
    for name in SIGNALS:
        origin, known = recording.origins[NAMES[name]], np.isfinite(getattr(table, f"recorded_{name}")).sum()
        if not origin.is_known:
            lines.append(f"{name}: not scored, the human's is {origin.kind}")
        elif known < count:
            lines.append(f"{name}: scored in {known} of {count} frames; elsewhere the human's is unknown")
    count_unseen = int((unseen(table) & _has_lane(table)).sum())
    if count_unseen:
        lines.append(f"{count_unseen} of {count} scored frames are unseen: no image, or the last command held")
    return lines


def unseen(table: FrameTable) -> Bools:
    """(N,) frames without an image, or with the last command held."""
    return np.asarray((table.image == 0.0) | (table.held == 1.0))


def _has_lane(table: FrameTable) -> Bools:
    """(N,) frames with a lane; all frames for a driver without lane detection."""
    return np.asarray(table.road_found != 0.0)


def _lane_masks(table: FrameTable) -> dict[str, Bools]:
    """Frames with and without a lane; both empty for a driver without lane detection."""
    return {"found": table.road_found == 1.0, "not_found": table.road_found == 0.0}


def _steering_beside_idle(
    scores: Callable[[Bools | None, bool], dict[str, Accuracy | None]], mask: Bools
) -> dict[str, Any]:
    """Steering scores in the frames of a mask; None where it is empty."""
    return {
        "frames": int(mask.sum()),
        "steering": scores(mask, False)["steering"],
        "idle": scores(mask, True)["steering"],
    }


def part_masks(table: FrameTable, rate_hz: float) -> dict[str, Bools | None]:
    """Frames of each part, by labels if there are any, else by the driver's detection."""
    labelled = np.isfinite(table.obstacle_labelled).any()
    flags = table.obstacle_labelled if labelled else persistent(table.obstacle_detected, rate_hz)
    if not np.isfinite(flags).any():
        return dict.fromkeys(PARTS)
    return {PARTS[0]: flags == 0.0, PARTS[1]: flags == 1.0}


def _accuracy(table: FrameTable, name: str, recorded: Floats, mask: Bools, idle: bool) -> Accuracy | None:
    predicted = np.zeros(len(table)) if idle else getattr(table, name)
    there = recorded[np.isfinite(recorded)]
    span = float(np.ptp(there)) if len(there) else 0.0
    scored = accuracy(predicted[mask], recorded[mask], span if span > LEAST_SPAN else 0.0)
    return scored and {key: rounded(value) for key, value in scored.items()}


def perception(table: FrameTable, recording: Recording) -> dict[str, Any]:
    """Perception scores against the ground truth that the recording has."""
    rate, speed = (_measured(recording, name)[: len(table)] for name in ("yaw_rate_radps", "speed_mps"))
    return {
        "foe": foe(table),
        "yaw_rate_median_error_radps": rounded(_median(np.abs(table.flow_yaw_rate_radps - table.yaw_rate_radps)[rate])),
        "speed_scale": _spread(_ratio(table)[speed]),
        "ttc": time_to_contact(table),
        "road_found_share": rounded(_mean(table.road_found)),
    }


def _measured(recording: Recording, name: str) -> Bools:
    """(N,) where a signal does not come from the flow that it would judge."""
    return recording.known(name) & (IMAGES not in recording.origins[name].inputs)


def foe(table: FrameTable) -> dict[str, Any]:
    """Share of frames with a focus of expansion after the first while moving, and its interquartile range, px."""
    eligible = (table.image == 1.0) & (table.frame > 0.0) & (table.speed_mps > STANDING_MPS)
    given = eligible & np.isfinite(table.foe_x_px)
    spread = {axis: _range(values[given]) for axis, values in (("x", table.foe_x_px), ("y", table.foe_y_px))}
    return {
        "share": rounded(float(given.sum() / eligible.sum())) if eligible.any() and table_sees(table) else None,
        "interquartile_range_px": spread if given.any() else None,
    }


def table_sees(table: FrameTable) -> bool:
    """Whether the driver reports a focus of expansion at all."""
    return bool(np.isfinite(table.foe_confidence).any())


def foe_error(table: FrameTable, which: str) -> dict[str, float] | None:
    """px, median absolute errors in x and y of `foe` or `own_foe`; None without ground truth."""
    pairs = (("x", "true_foe_x_px"), ("y", "true_foe_y_px"))
    errors = {axis: getattr(table, f"{which}_{axis}_px") - getattr(table, truth) for axis, truth in pairs}
    medians = {axis: _median(np.abs(values)) for axis, values in errors.items()}
    return (
        None if None in medians.values() else {axis: round(float(value or 0.0), 3) for axis, value in medians.items()}
    )


def time_to_contact(table: FrameTable) -> dict[str, Any] | None:
    """Errors against the gap to the lead vehicle; None if it is not recorded.

    median_error: |TTC - true| / true where the gap closes faster than 0.5 m/s, over frames with a TTC;
    within_25_percent and seen: their shares. false_alarms: share of frames below 4 s while both stand.
    """
    if not np.isfinite(table.lead_gap_m).any():
        return None
    closing = closing_mps(table.lead_gap_m, table.time_s)
    true = true_ttc_s(table.lead_gap_m, closing)
    near = (closing > LEAST_CLOSING_MPS) & (table.image == 1.0)
    given = near & np.isfinite(table.ttc_s)
    error = np.abs(table.ttc_s - true)[given] / true[given]
    still = (np.abs(closing) < STANDING_MPS) & (table.speed_mps < STANDING_MPS) & (table.image == 1.0)
    return {
        "frames": int(near.sum()),
        "seen": rounded(float(given.sum() / near.sum())) if near.any() else None,
        "median_error": rounded(_median(error)),
        "within_25_percent": rounded(float(np.mean(error <= 0.25))) if len(error) else None,
        "standing_frames": int(still.sum()),
        "false_alarms": rounded(float(np.mean(table.ttc_s[still] < ALARM_S))) if still.any() else None,
    }


def signal_checks(recording: Recording) -> dict[str, Any]:
    """Whether independent signals agree by physics: yaw rate = v tan(delta) / L, L = 2.7 m.

    gain is the slope through 0 of the yaw rate over v tan(delta) / L: 1 for a correct ratio, wheelbase and sign
    without slip, negative for a wrong sign. An understeering car has 1 / (1 + (v / v_c)^2), with a characteristic
    speed v_c of about 25 m/s (Rajamani, Vehicle Dynamics and Control, 2012, ch. 3).
    """
    kinds = {name: recording.origins[name] for name in ("speed_mps", "yaw_rate_radps", "steering_rad", "throttle")}
    result: dict[str, Any] = {"origins": {name: str(origin) for name, origin in kinds.items()}}
    bent = recording.speed_mps * np.tan(recording.steering_rad) / WHEELBASE_M
    known = np.isfinite(bent) & recording.known("speed_mps") & recording.known("yaw_rate_radps")
    if not _are_independent(kinds) or np.count_nonzero(known) < 3 or np.ptp(bent[known]) <= 0.0:
        return {**result, "yaw_rate": None}
    x, y = bent[known], recording.yaw_rate_radps[known]
    correlation = float(np.corrcoef(x, y)[0, 1]) if np.ptp(y) > 0.0 else None
    return {**result, "yaw_rate": {"gain": rounded(float(x @ y / (x @ x))), "correlation": rounded(correlation)}}


def _are_independent(origins: dict[str, Origin]) -> bool:
    """Whether steering and yaw rate were measured independently."""
    return origins["steering_rad"].kind == "recorded" and "steering_rad" not in origins["yaw_rate_radps"].inputs


WHEELBASE_M = 2.7


def rounded(value: float | None) -> float | None:
    """Rounded to DIGITS decimals; None if not finite."""
    return None if value is None or not np.isfinite(value) else round(value, DIGITS) + 0.0


def _median(values: Floats) -> float | None:
    finite = values[np.isfinite(values)]
    return float(np.median(finite)) if len(finite) else None


def _mean(values: Floats) -> float | None:
    finite = values[np.isfinite(values)]
    return float(np.mean(finite)) if len(finite) else None


def _range(values: Floats) -> float | None:
    return rounded(float(np.subtract(*np.percentile(values, [75.0, 25.0])))) if len(values) else None


def _ratio(table: FrameTable) -> Floats:
    """(N,) speed by the flow / recorded, where the car moves."""
    moving = table.speed_mps > LEAST_SPEED_MPS
    return np.where(moving, table.flow_speed_mps, np.nan) / np.where(moving, table.speed_mps, 1.0)


def _spread(values: Floats) -> dict[str, float | None] | None:
    """Median and interquartile range."""
    finite = values[np.isfinite(values)]
    return {"median": rounded(_median(finite)), "interquartile_range": _range(finite)} if len(finite) else None
