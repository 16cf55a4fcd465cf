"""Perception metrics of an episode against the renderer's ground truth."""

import numpy as np

from vpf_sim.evaluation.steps import StepTable
from vpf_sim.scenarios.kinds import SIZES, ObjectKind
from vpf_sim.types import Floats

KINDS = tuple(SIZES)
# Distance from bumper to face at which a driver should have confirmed an obstacle; small and flat ones later.
DUE_M: dict[ObjectKind, float] = {**dict.fromkeys(KINDS, 15.0), "cone": 10.0, "pallet": 6.0}


def foe(x_px: Floats, y_px: Floats, true_x_px: Floats, true_y_px: Floats) -> dict[str, object]:
    """Error of the focus of expansion, px: medians of |dx|, |dy| and the distance over frames with an estimate.

    `foe_share` is their share among the frames that have a true one (the car moves).
    """
    known = np.isfinite(true_x_px)
    given = known & np.isfinite(x_px)
    if not given.any():
        return {"foe_median_error_px": None, "foe_share": 0.0 if known.any() else None}
    dx, dy = (x_px - true_x_px)[given], (y_px - true_y_px)[given]
    errors = {"x": np.abs(dx), "y": np.abs(dy), "distance": np.hypot(dx, dy)}
    medians = {name: float(np.median(values)) for name, values in errors.items()}
    return {"foe_median_error_px": medians, "foe_share": float(given.sum() / known.sum())}


def edges(estimated_m: Floats, true_m: Floats) -> dict[str, object]:
    """Error of the carriageway's edges 10 m ahead, m: median and 95th percentile of (N,) absolute differences."""
    error = np.abs(estimated_m - true_m)
    error = error[np.isfinite(error)]
    if len(error) == 0:
        return {"edge_error_10m_m": None}
    return {"edge_error_10m_m": {"median": float(np.median(error)), "p95": float(np.percentile(error, 95.0))}}


def points(flow_error_px: Floats, ttc_error: Floats) -> dict[str, object]:
    """Medians over the scored frames of the flow's end-point error, px, and of |TTC - true| / true.

    Only points with a true time to contact of at most 10 s count; a missing estimate has error 1.
    """
    return {"flow_median_error_px": _median(flow_error_px), "ttc_median_error": _median(ttc_error)}


def objects(table: StepTable) -> dict[str, object] | None:
    """Detection metrics of the obstacles in the ego's corridor; None for a driver that reports none.

    met: obstacles that the ego reached; confirmed: those with a correct detection before; first_confirmed_m: median
    distance, m, from bumper to face, of the first; recall: share of the met that were confirmed by DUE_M; precision:
    correct detections / all, over all frames; wrong_per_minute: new false positives a minute of driving.
    """
    reported = np.isfinite(table.objects_right)
    if not reported.any():
        return None
    met = np.isfinite(table.met_kind)
    kinds, confirmed_m = table.met_kind[met].astype(int), table.met_confirmed_m[met]
    due_m = np.array([DUE_M[KINDS[kind]] for kind in kinds])
    right, wrong = np.sum(table.objects_right[reported]), np.sum(table.objects_wrong[reported])
    minutes = (table.time_s[-1] - table.time_s[0]) / 60.0
    return {
        "met": len(kinds),
        "confirmed": int(np.sum(np.isfinite(confirmed_m))),
        "first_confirmed_m": _median(confirmed_m),
        "recall": float(np.mean(confirmed_m >= due_m)) if len(kinds) else None,
        "precision": float(right / (right + wrong)) if right + wrong else None,
        "wrong_per_minute": float(np.nansum(table.new_wrong_objects) / minutes) if minutes > 0.0 else None,
    }


def _median(values: Floats) -> float | None:
    finite = values[np.isfinite(values)]
    return float(np.median(finite)) if len(finite) else None
