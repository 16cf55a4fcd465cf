"""The record of an episode: its scores, a function of scenario, weather, driver, seed and fingerprint."""

from hashlib import sha256
from math import isfinite
from typing import Any

import numpy as np

from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.metrics import chattering, clearance, collision, comfort, driving_score, path, perception
from vpf_sim.evaluation.metrics.accuracy import protocol
from vpf_sim.evaluation.outcome import Outcome
from vpf_sim.evaluation.steps import StepTable
from vpf_sim.types import Floats


def score(job: Job, outcome: Outcome, route: Floats, route_length_m: float) -> dict[str, Any]:
    """The record of an episode; `route` has waypoints (M, 2) from the start to beyond the goal at `route_length_m`."""
    table = outcome.steps
    if len(table) == 0:
        return failed(job, outcome.status, outcome.invalid_frame)
    hits = [outcome.collided_with] if outcome.collided_with else []
    completion = 1.0 if outcome.status == "success" else path.completion(table.route_m, route_length_m)
    off_lane = driving_score.off_lane_share(table.route_m, table.outside)
    record: dict[str, Any] = finite(
        {
            **_identity(job),
            "status": outcome.status,
            "invalid_frame": outcome.invalid_frame,
            "route_completion": completion,
            **_path_mse(table, path.shorten(route, route_length_m)),
            "max_lane_offset_m": np.max(np.abs(table.lane_offset_m)),
            "accuracy": _accuracy(table),
            "collisions": len(hits),
            "collided_with": outcome.collided_with,
            **_fault(table, hits),
            "min_clearance_m": clearance.min_clearance_m(table.clearance_m),
            "driving_score_2_0": driving_score.driving_score_2_0(completion, hits, off_lane),
            "driving_score_2_1": driving_score.driving_score_2_1(completion, hits, off_lane),
            "comfort": comfort.comfort(table),
            "chattering": chattering.chattering(table),
            "perception": _perception(table),
            "steps": len(table),
            "states_sha256": sha256(table.states()).hexdigest(),
            "frames_sha256": outcome.frames_sha256,
        }
    )
    return record


def failed(job: Job, status: str = "error", invalid_frame: dict[str, Any] | None = None) -> dict[str, Any]:
    """The record of an episode without scores: it never began, or its worker died."""
    drive_keys = ("path_mse_m2", "path_mse_parts_m2", "max_lane_offset_m", "accuracy", "min_clearance_m")
    other_keys = ("comfort", "chattering", "perception", "collided_with", "collision_type")
    scores = dict.fromkeys((*drive_keys, *other_keys))
    zeros = dict.fromkeys(("route_completion", "driving_score_2_0", "driving_score_2_1"), 0.0)
    zeros |= {"collisions": 0, "at_fault_collisions": 0}
    hashes = {"steps": 0, "states_sha256": None, "frames_sha256": None}
    return {**_identity(job), "status": status, "invalid_frame": invalid_frame, **scores, **zeros, **hashes}


def finite(value: Any) -> Any:
    """The value with plain Python numbers, and None for nan and inf."""
    if isinstance(value, dict):
        return {key: finite(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [finite(inner) for inner in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not isfinite(value) else value


def _identity(job: Job) -> dict[str, Any]:
    return {"id": job.id, **job._asdict()}


def _path_mse(table: StepTable, reference: Floats) -> dict[str, Any]:
    """Path MSE of the whole route and of its two parts."""
    passing = table.passing > 0.0
    parts = {"clear_of_obstacles": ~passing, "passing": passing}
    return {
        "path_mse_m2": path.path_mse(table.positions_m, reference),
        "path_mse_parts_m2": {part: path.path_mse(table.positions_m[rows], reference) for part, rows in parts.items()},
    }


def _accuracy(table: StepTable) -> dict[str, Any]:
    """Accuracy by both protocols, over the n states with a command."""
    driven = slice(0, len(table))
    commands, shadow, paired = (
        {name: getattr(table, f"{whose}{name}")[driven] for name in ("throttle", "steering")}
        for whose in ("", "pid_", "paired_")
    )
    passing = table.passing[driven] > 0.0
    return {"shadow": protocol(commands, shadow, passing), "paired": protocol(commands, paired, passing)}


def _fault(table: StepTable, hits: list[str]) -> dict[str, Any]:
    if not hits:
        return {"collision_type": None, "at_fault_collisions": 0}
    kind = collision.collision_type(table)
    return {"collision_type": kind, "at_fault_collisions": int(collision.is_at_fault(kind, table))}


def _perception(table: StepTable) -> dict[str, Any]:
    estimated = np.concatenate([table.seen_left_m, table.seen_right_m])
    true = np.concatenate([table.true_left_m, table.true_right_m])
    return {
        **perception.foe(table.foe_x_px, table.foe_y_px, table.true_foe_x_px, table.true_foe_y_px),
        **perception.edges(estimated, true),
        **perception.points(table.flow_error_px, table.ttc_error),
        "objects": perception.objects(table),
    }
