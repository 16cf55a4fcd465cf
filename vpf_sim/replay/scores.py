"""Scores of a replayed driver: commands beside the human's, perception against ground truth."""

from typing import get_args

import numpy as np

from vpf_sim.evaluation.metrics.tracking import accuracy
from vpf_sim.replay import records
from vpf_sim.replay.frame_table import FrameTable
from vpf_sim.replay.obstacles_ahead import closing_mps, persistent, true_ttc_s
from vpf_sim.replay.recording import IMAGES, Origin, Recording
from vpf_sim.replay.records import Agreement, Commands, Counts, LanePart, Pixels, Signal
from vpf_sim.types import Bools, Floats

PARTS = ("clear_of_obstacles", "with_obstacles")
SIGNALS: tuple[Signal, ...] = get_args(Signal)
NAMES = {"throttle": "throttle", "steering": "steering_rad"}  # their names in a recording
LEAST_CLOSING_MPS = 0.5  # least closing speed for comparing the time to contact
STANDING_MPS = 0.3  # of car and gap: nothing approaches
LEAST_SPEED_MPS = 2.0  # least speed for comparing it
ALARM_S = 4.0  # time to contact that calls for braking
LEAST_SPAN = 0.005  # least span of a signal for the span accuracy
DIGITS = 6  # of stored scores
WHEELBASE_M = 2.7


def accuracies(table: FrameTable, recording: Recording) -> records.Accuracies | None:
    """Accuracy of throttle and steering, overall and with and without obstacles; None if not driven.

    Frames without a lane are not scored, nor is an assumed signal or one that follows from it.
    """
    if not any(np.isfinite(getattr(table, name)).any() for name in SIGNALS):
        return None
    whole, parts, has_lane = np.ones(len(table), np.bool_), part_masks(table, recording.rate_hz), _has_lane(table)

    def of(mask: Bools | None, idle: bool) -> Commands:
        return Commands(**{name: _agreement(table, recording, name, mask, idle) for name in SIGNALS})

    def by_part(idle: bool) -> records.ByPart:
        by_part = {part: of(mask, idle) for part, mask in parts.items()}
        return records.ByPart.model_validate({**dict(of(whole, idle)), **by_part})

    def counted(frames: Bools) -> Counts:
        numbers = {part: None if mask is None else int((mask & frames).sum()) for part, mask in parts.items()}
        return Counts(whole=int(frames.sum()), **numbers)

    def lane(mask: Bools) -> LanePart:
        return LanePart(frames=int(mask.sum()), steering=of(mask, False).steering, idle=of(mask, True).steering)

    return records.Accuracies(
        **dict(by_part(False)),
        frames=counted(has_lane),
        unseen=counted(has_lane & unseen(table)),
        idle=by_part(True),
        lane=records.Lanes(found=lane(table.road_found == 1.0), not_found=lane(table.road_found == 0.0)),
    )


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


def part_masks(table: FrameTable, rate_hz: float) -> dict[str, Bools | None]:
    """Frames of each part, by labels if there are any, else by the driver's detection."""
    labelled = np.isfinite(table.obstacle_labelled).any()
    flags = table.obstacle_labelled if labelled else persistent(table.obstacle_detected, rate_hz)
    if not np.isfinite(flags).any():
        return dict.fromkeys(PARTS)
    return {PARTS[0]: flags == 0.0, PARTS[1]: flags == 1.0}


def _agreement(
    table: FrameTable, recording: Recording, name: Signal, mask: Bools | None, idle: bool
) -> Agreement | None:
    """The agreement of a signal in the frames of a mask, of no command if `idle`; None where there are none."""
    if mask is None or not recording.origins[NAMES[name]].is_known:
        return None
    human, own = getattr(table, f"recorded_{name}"), getattr(table, name)
    known = np.isfinite(human)
    span = float(np.ptp(human[known])) if known.any() else 0.0
    scored = known & np.isfinite(own) & _has_lane(table) & mask
    found = accuracy(np.zeros(scored.sum()) if idle else own[scored], human[scored], span if span > LEAST_SPAN else 0.0)
    return Agreement(**{key: rounded(value) for key, value in found.items()}) if found else None


def perception(table: FrameTable, recording: Recording) -> records.PerceptionScores:
    """Perception scores against the ground truth that the recording has."""
    rate, speed = (_measured(recording, name)[: len(table)] for name in ("yaw_rate_radps", "speed_mps"))
    return records.PerceptionScores(
        foe=foe(table),
        yaw_rate_median_error_radps=rounded(_median(np.abs(table.flow_yaw_rate_radps - table.yaw_rate_radps)[rate])),
        speed_scale=_spread(_ratio(table)[speed]),
        ttc=time_to_contact(table),
        road_found_share=rounded(_mean(table.road_found)),
    )


def _measured(recording: Recording, name: str) -> Bools:
    """(N,) where a signal does not come from the flow that it would judge."""
    return recording.known(name) & (IMAGES not in recording.origins[name].inputs)


def foe(table: FrameTable) -> records.Foe:
    """The focus of expansion in the frames after the first while moving."""
    eligible = (table.image == 1.0) & (table.frame > 0.0) & (table.speed_mps > STANDING_MPS)
    given = eligible & np.isfinite(table.foe_x_px)
    is_reported = eligible.any() and np.isfinite(table.foe_confidence).any()
    share = rounded(float(given.sum() / eligible.sum())) if is_reported else None
    spread = Pixels(x=_range(table.foe_x_px[given]), y=_range(table.foe_y_px[given])) if given.any() else None
    return records.Foe(share=share, interquartile_range_px=spread)


def foe_error(table: FrameTable, which: str) -> Pixels | None:
    """px, median absolute errors in x and y of `foe` or `own_foe`; None without ground truth."""
    x, y = (
        _median(np.abs(getattr(table, f"{which}_{axis}_px") - getattr(table, f"true_foe_{axis}_px"))) for axis in "xy"
    )
    return None if x is None or y is None else Pixels(x=round(x, 3), y=round(y, 3))


def time_to_contact(table: FrameTable) -> records.TtcScores | None:
    """Errors against the gap to the lead vehicle; None if it is not recorded.

    median_error: |TTC - true| / true where the gap closes faster than 0.5 m/s, over frames with a TTC;
    within_25_percent and seen: their shares. false_alarms: share of frames below 4 s while both are stationary.
    """
    if not np.isfinite(table.lead_gap_m).any():
        return None
    closing = closing_mps(table.lead_gap_m, table.time_s)
    true = true_ttc_s(table.lead_gap_m, closing)
    near = (closing > LEAST_CLOSING_MPS) & (table.image == 1.0)
    given = near & np.isfinite(table.ttc_s)
    error = np.abs(table.ttc_s - true)[given] / true[given]
    still = (np.abs(closing) < STANDING_MPS) & (table.speed_mps < STANDING_MPS) & (table.image == 1.0)
    return records.TtcScores(
        frames=int(near.sum()),
        seen=rounded(float(given.sum() / near.sum())) if near.any() else None,
        median_error=rounded(_median(error)),
        within_25_percent=rounded(float(np.mean(error <= 0.25))) if len(error) else None,
        standing_frames=int(still.sum()),
        false_alarms=rounded(float(np.mean(table.ttc_s[still] < ALARM_S))) if still.any() else None,
    )


def signal_checks(recording: Recording) -> records.SignalChecks:
    """Whether independent signals agree by physics: yaw rate = v tan(delta) / L, L = 2.7 m.

    gain is the slope through 0 of the yaw rate over v tan(delta) / L: 1 for a correct ratio, wheelbase and sign
    without slip, negative for a wrong sign. An understeering car has 1 / (1 + (v / v_c)^2), with a characteristic
    speed v_c of about 25 m/s (Rajamani, Vehicle Dynamics and Control, 2012, ch. 3).
    """
    kinds = {name: recording.origins[name] for name in ("speed_mps", "yaw_rate_radps", "steering_rad", "throttle")}
    origins = {name: str(origin) for name, origin in kinds.items()}
    bent = recording.speed_mps * np.tan(recording.steering_rad) / WHEELBASE_M
    known = np.isfinite(bent) & recording.known("speed_mps") & recording.known("yaw_rate_radps")
    if not _are_independent(kinds) or np.count_nonzero(known) < 3 or np.ptp(bent[known]) <= 0.0:
        return records.SignalChecks(origins=origins, yaw_rate=None)
    x, y = bent[known], recording.yaw_rate_radps[known]
    correlation = float(np.corrcoef(x, y)[0, 1]) if np.ptp(y) > 0.0 else None
    check = records.YawRateCheck(gain=rounded(float(x @ y / (x @ x))), correlation=rounded(correlation))
    return records.SignalChecks(origins=origins, yaw_rate=check)


def _are_independent(origins: dict[str, Origin]) -> bool:
    """Whether steering and yaw rate were measured independently."""
    return origins["steering_rad"].kind == "recorded" and "steering_rad" not in origins["yaw_rate_radps"].inputs


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


def _spread(values: Floats) -> records.Spread | None:
    finite = values[np.isfinite(values)]
    return records.Spread(median=rounded(_median(finite)), interquartile_range=_range(finite)) if len(finite) else None
