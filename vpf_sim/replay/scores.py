"""How right a driver was on a recording: its commands beside the human's, and what it saw beside the truth."""

from collections.abc import Callable
from typing import Any

import numpy as np

from vpf_sim.evaluation.metrics.accuracy import Accuracy, accuracy
from vpf_sim.replay.frame_table import FrameTable
from vpf_sim.replay.obstacles_ahead import closing_mps, lasting, true_ttc_s
from vpf_sim.replay.recording import PICTURES, Origin, Recording
from vpf_sim.types import Bools, Floats

PARTS = ("clear_of_obstacles", "with_obstacles")
SIGNALS = ("throttle", "steering")
NAMES = {"throttle": "throttle", "steering": "steering_rad"}  # theirs in a recording
LEAST_CLOSING_MPS = 0.5  # of a gap whose time to contact is compared
STANDING_MPS = 0.3  # of the car and of the gap: nothing approaches
LEAST_SPEED_MPS = 2.0  # of a speed that is compared
ALARM_S = 4.0  # a time to contact that calls for the brake
LEAST_SPAN = 0.005  # of a signal that moved; of one that did not the span says nothing
DIGITS = 6  # of stored scores


def accuracies(table: FrameTable, recording: Recording) -> dict[str, Any] | None:
    """Of throttle and steering, whole and in parts with and without obstacles; None where nobody drove.

    Frames in which no lane was found are not scored: there the driver decided nothing. A signal that is assumed, or
    follows from one that is, has no score. Beside the driver's stands `idle`, the accuracy of touching nothing: what of
    it is the road's and not the driver's; `frames`, how many of each part are scored; and `unseen`, in how many of
    these the driver did not see.
    """
    recorded = {"throttle": table.recorded_throttle, "steering": table.recorded_steering}
    driven = {name: np.isfinite(getattr(table, name)) for name in SIGNALS}
    if not any(there.any() for there in driven.values()):
        return None
    told = {name: np.isfinite(values) & recording.origins[NAMES[name]].is_known for name, values in recorded.items()}
    decided = _decided(table)
    known = {name: told[name] & driven[name] & decided for name in SIGNALS}
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
        "frames": {name: None if mask is None else int((mask & decided).sum()) for name, mask in masks.items()},
        "unseen": {name: None if mask is None else int((mask & decided & blind).sum()) for name, mask in masks.items()},
        "idle": {**scores(whole, True), **{part: scores(parts[part], True) for part in PARTS}},
        "lane": {name: _steering_beside_idle(scores, mask) for name, mask in _lane_masks(table).items()},
    }


def doubts(table: FrameTable, recording: Recording) -> list[str]:
    """What a reader of the scores must know of them, a line each."""
    if not np.isfinite(table.throttle).any():
        return []
    lines: list[str] = []
    count = len(table)
    for name in SIGNALS:
        origin, known = recording.origins[NAMES[name]], np.isfinite(getattr(table, f"recorded_{name}")).sum()
        if not origin.is_known:
            lines.append(f"{name}: not scored, the human's is {origin.kind}")
        elif known < count:
            lines.append(f"{name}: scored in {known} of {count} frames, elsewhere the human's is not known")
    blind = int((unseen(table) & _decided(table)).sum())
    if blind:
        lines.append(f"{blind} of {count} frames are scored unseen: there was no picture, or the last command held")
    return lines


def unseen(table: FrameTable) -> Bools:
    """(N,) frames at which the driver's command is not by what it saw: the last one holds, or there is no picture."""
    return np.asarray((table.image == 0.0) | (table.held == 1.0))


def _decided(table: FrameTable) -> Bools:
    """(N,) all but the frames in which no lane was found; of a driver that looks for none, all."""
    return np.asarray(table.road_found != 0.0)


def _lane_masks(table: FrameTable) -> dict[str, Bools]:
    """Frames in which a lane was found, and in which none was; both empty for a driver that looks for none."""
    return {"found": table.road_found == 1.0, "not_found": table.road_found == 0.0}


def _steering_beside_idle(
    scores: Callable[[Bools | None, bool], dict[str, Accuracy | None]], mask: Bools
) -> dict[str, Any]:
    """Both are None where no lane was found."""
    return {
        "frames": int(mask.sum()),
        "steering": scores(mask, False)["steering"],
        "idle": scores(mask, True)["steering"],
    }


def part_masks(table: FrameTable, rate_hz: float) -> dict[str, Bools | None]:
    """Which frames are in which part: by the labels where there are any, or else by the driver's own detection."""
    labelled = np.isfinite(table.obstacle_labelled).any()
    flags = table.obstacle_labelled if labelled else lasting(table.obstacle_seen, rate_hz)
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
    """What the flow says of the own motion and of the body ahead, beside the truth where the recording has it."""
    rate, speed = (_measured(recording, name)[: len(table)] for name in ("yaw_rate_radps", "speed_mps"))
    return {
        "foe": foe(table),
        "yaw_rate_median_error_radps": rounded(_median(np.abs(table.flow_yaw_rate_radps - table.yaw_rate_radps)[rate])),
        "speed_scale": _spread(_ratio(table)[speed]),
        "ttc": time_to_contact(table),
        "road_found_share": rounded(_mean(table.road_found)),
    }


def _measured(recording: Recording, name: str) -> Bools:
    """(N,) where a signal comes from elsewhere than the pictures' own flow, which it could not judge."""
    return recording.known(name) & (PICTURES not in recording.origins[name].inputs)


def foe(table: FrameTable) -> dict[str, Any]:
    """How often it was there, of the frames after the first that moved, and how far it spread: quartiles' range, px."""
    looked = (table.image == 1.0) & (table.frame > 0.0) & (table.speed_mps > STANDING_MPS)
    given = looked & np.isfinite(table.foe_x_px)
    spread = {axis: _range(values[given]) for axis, values in (("x", table.foe_x_px), ("y", table.foe_y_px))}
    return {
        "share": rounded(float(given.sum() / looked.sum())) if looked.any() and table_sees(table) else None,
        "interquartile_range_px": spread if given.any() else None,
    }


def table_sees(table: FrameTable) -> bool:
    """Whether a driver told of a focus of expansion, wherever it was."""
    return bool(np.isfinite(table.foe_confidence).any())


def foe_error(table: FrameTable, which: str) -> dict[str, float] | None:
    """px, medians of the absolute errors in x and y of `foe` or `own_foe`; None without a frame that has both."""
    pairs = (("x", "true_foe_x_px"), ("y", "true_foe_y_px"))
    errors = {axis: getattr(table, f"{which}_{axis}_px") - getattr(table, truth) for axis, truth in pairs}
    medians = {axis: _median(np.abs(values)) for axis, values in errors.items()}
    return (
        None if None in medians.values() else {axis: round(float(value or 0.0), 3) for axis, value in medians.items()}
    )


def time_to_contact(table: FrameTable) -> dict[str, Any] | None:
    """Against the gap to the body ahead; None where the recording has none.

    median_error: |TTC - true| / true where the gap closes by more than 0.5 m/s, over the frames that have a TTC;
    within_25_percent and seen: their shares. false_alarms: the share of frames with less than 4 s while both stand.
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
    """Whether signals that were measured apart agree, by physics: yaw rate = v tan(delta) / L, a wheelbase of 2.7 m.

    gain is the slope through 0 of the yaw rate over v tan(delta) / L: 1 where ratio, wheelbase and signs are right and
    no tyre slips, < 0 where a sign is wrong. A car that understeers turns by 1 / (1 + (v / v_c)^2) of it, with a
    characteristic speed v_c of some 25 m/s (Rajamani, Vehicle Dynamics and Control, 2012, ch. 3).
    """
    kinds = {name: recording.origins[name] for name in ("speed_mps", "yaw_rate_radps", "steering_rad", "throttle")}
    result: dict[str, Any] = {"origins": {name: str(origin) for name, origin in kinds.items()}}
    bent = recording.speed_mps * np.tan(recording.steering_rad) / WHEELBASE_M
    known = np.isfinite(bent) & recording.known("speed_mps") & recording.known("yaw_rate_radps")
    if not _are_apart(kinds) or np.count_nonzero(known) < 3 or np.ptp(bent[known]) <= 0.0:
        return {**result, "yaw_rate": None}
    x, y = bent[known], recording.yaw_rate_radps[known]
    correlation = float(np.corrcoef(x, y)[0, 1]) if np.ptp(y) > 0.0 else None
    return {**result, "yaw_rate": {"gain": rounded(float(x @ y / (x @ x))), "correlation": rounded(correlation)}}


def _are_apart(origins: dict[str, Origin]) -> bool:
    """Whether steering and yaw rate were measured each by itself."""
    return origins["steering_rad"].kind == "recorded" and "steering_rad" not in origins["yaw_rate_radps"].inputs


WHEELBASE_M = 2.7


def rounded(value: float | None) -> float | None:
    """With DIGITS decimals; None for what is not finite."""
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
    """Median and quartiles' range."""
    finite = values[np.isfinite(values)]
    return {"median": rounded(_median(finite)), "interquartile_range": _range(finite)} if len(finite) else None
