"""What the driver saw, against the truth of the renderer."""

import numpy as np

from vpf_sim.types import Floats


def foe(x_px: Floats, y_px: Floats, true_x_px: Floats, true_y_px: Floats) -> dict[str, object]:
    """Error of the focus of expansion, px: medians of |dx|, |dy| and the distance, over the frames where it was given.

    `foe_share` is how many of the frames with a true one (the car moves) those are.
    """
    known = np.isfinite(true_x_px)
    given = known & np.isfinite(x_px)
    if not given.any():
        return {"foe_median_error_px": None, "foe_share": 0.0 if known.any() else None}
    dx, dy = (x_px - true_x_px)[given], (y_px - true_y_px)[given]
    errors = {"x": np.abs(dx), "y": np.abs(dy), "distance": np.hypot(dx, dy)}
    medians = {name: float(np.median(values)) for name, values in errors.items()}
    return {"foe_median_error_px": medians, "foe_share": float(given.sum() / known.sum())}


def edges(seen_m: Floats, true_m: Floats) -> dict[str, object]:
    """Error of the carriageway's edges 10 m ahead, m: median and 95th percentile of the (N,) absolute differences."""
    error = np.abs(seen_m - true_m)
    error = error[np.isfinite(error)]
    if len(error) == 0:
        return {"edge_error_10m_m": None}
    return {"edge_error_10m_m": {"median": float(np.median(error)), "p95": float(np.percentile(error, 95.0))}}
