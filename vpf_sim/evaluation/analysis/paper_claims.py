"""The paper's claims about its simulator runs, each compared with what a run measured."""

from collections.abc import Sequence
from dataclasses import dataclass

from vpf_sim.evaluation.analysis.benchmark import SCENARIOS, WEATHERS
from vpf_sim.evaluation.analysis.reproduction import CELLS, CellResult, Drive, definitions, mean

REACHED_SHARE = 0.9  # of a cell's drives that counts as reaching the goal: the paper shows one drive a condition
IN_LANE_SHARE = 0.99  # of the distance within one lane that counts as staying in it
CLEAR, RAIN = WEATHERS
FREE, OBSTACLES = SCENARIOS


@dataclass(frozen=True, slots=True)
class Claim:
    """A sentence of the paper, what was measured, and whether it holds; None where the run cannot decide."""

    claim: str
    measured: str
    holds: bool | None

    @property
    def verdict(self) -> str:
        return {True: "holds", False: "does not hold", None: "undecided"}[self.holds]


def claims(rows: Sequence[CellResult], drives: Sequence[Drive], driver_ms: float | None) -> list[Claim]:
    """The paper's claims; `driver_ms` is the driver's time per frame."""
    passed = any(drive.succeeded and drive.scenario == OBSTACLES for drive in drives)
    return [
        _reaches_destination(rows),
        _avoids_obstacles(rows, passed),
        _jerkier("with obstacles", rows, [((OBSTACLES, weather), (FREE, weather)) for weather in WEATHERS]),
        _jerkier("in rain", rows, [((scenario, RAIN), (scenario, CLEAR)) for scenario in SCENARIOS]),
        _leaves_lane(rows, passed),
        _error_below_one(rows),
        _error_grows(rows),
        _accuracies_fall(rows),
        Claim(
            "It takes less computation than learning.",
            f"{_number(driver_ms)} ms a frame on one core" if driver_ms is not None else "not timed",
            None,
        ),
    ]


def reaches_goal(row: CellResult) -> bool:
    """Whether at least REACHED_SHARE of a cell's drives reached the goal."""
    return bool(row.episodes and row.successes >= REACHED_SHARE * row.episodes)


def _reaches_destination(rows: Sequence[CellResult]) -> Claim:
    reached = ", ".join(f"{row.successes} of {row.episodes}" for row in rows)
    names = ", ".join(f"{weather} {'without' if scenario == FREE else 'with'} obstacles" for scenario, weather in CELLS)
    return Claim(
        "The vehicle reaches its destination in all four conditions (here: in nine drives of ten).",
        f"{reached} ({names})",
        all(reaches_goal(row) for row in rows),
    )


def _avoids_obstacles(rows: Sequence[CellResult], passed: bool) -> Claim:
    clearances = [row.clearance_m for row in rows if row.clearance_m is not None]
    return Claim(
        "It avoids both the obstacles and the road's edges (here: in nine drives of ten).",
        f"least clearance {_number(min(clearances, default=None))} m",
        passed and all(reaches_goal(row) for row in rows if row.scenario == OBSTACLES),
    )


def _jerkier(
    condition: str, rows: Sequence[CellResult], pairs: Sequence[tuple[tuple[str, str], tuple[str, str]]]
) -> Claim:
    """Whether the path is jerkier in the first cell of every pair than in the second."""
    by_cell = {row.cell: row.jerkiness_radps2 for row in rows}
    values = [(by_cell[one], by_cell[other]) for one, other in pairs]
    measured = ", ".join(f"{_number(one, 3)} against {_number(other, 3)}" for one, other in values)
    known = [one > other for one, other in values if one is not None and other is not None]
    holds = all(known) if len(known) == len(values) else None
    return Claim(f"Its path is jerkier {condition}.", f"{measured} rad/s2", holds)


def _leaves_lane(rows: Sequence[CellResult], passed: bool) -> Claim:
    shares = [row.in_lane_share for row in rows if row.in_lane_share is not None]
    return Claim(
        "It does not stay in its lane, since only the edges of the road bound it.",
        ", ".join(f"{_number(100.0 * share, 0)} %" for share in shares) + " of the distance within one lane",
        any(share < IN_LANE_SHARE for share in shares) if passed else None,
    )


def _error_below_one(rows: Sequence[CellResult]) -> Claim:
    error, printed = mean(_errors(rows)), mean([row.paper["path_mse_m2"] for row in rows])
    return Claim(
        "The mean squared error of the path is below 1 on average.",
        f"mean of the cells {_number(error)} m2; the paper's {_number(printed)}",
        None if error is None or None in _errors(rows) else error < 1.0,
    )


def _error_grows(rows: Sequence[CellResult]) -> Claim:
    errors = _errors(rows)
    present = [error for error in errors if error is not None]
    return Claim(
        "The error grows with obstacles and in rain.",
        ", ".join(_number(error) for error in errors) + " m2 in the order of the table",
        present == sorted(present) if len(present) == len(errors) else None,
    )


def _accuracies_fall(rows: Sequence[CellResult]) -> Claim:
    found = definitions(rows)
    matching = [row for row in found if row.throttle.same_order and row.steering.same_order]
    names = ", ".join(f"{row.definition} ({row.protocol})" for row in matching)
    return Claim(
        "The accuracies fall in the order of the table.",
        f"in this order by {names}" if matching else f"by none of {len(found)} definitions",
        None if None in _errors(rows) else bool(matching),
    )


def _errors(rows: Sequence[CellResult]) -> list[float | None]:
    """Path MSE to the lane's centre of each cell, m2."""
    return [row.lane_mse_m2 for row in rows]


def _number(value: float | None, digits: int = 2) -> str:
    return "-" if value is None else f"{value:.{digits}f}"
