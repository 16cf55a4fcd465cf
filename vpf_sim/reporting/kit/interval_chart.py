"""Dot charts of scores with intervals: one row per driver, one mark per weather, and the paper's values."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup

from vpf_sim.reporting.kit.chart import Axis, Plot, reach, ticks

WIDTH = 360.0
ROW, HEAD, FOOT = 20.0, 20.0, 18.0  # px
LETTER = 6.4  # px of a driver's name, for each letter
MOST_LETTERS = 22  # of a name
APART = 7.0  # between the weathers of a row
MARKS = ((False, False), (True, True), (False, True), (True, False))  # of each weather: (diamond, hollow)
SIGNS = "●◇○◆"  # the same marks as text


@dataclass(frozen=True, slots=True)
class Dot:
    """A value with its interval."""

    scenario: str
    driver: str
    weather: int  # index in the plan
    style: str
    value: float
    interval: tuple[float, float] | None


@dataclass(frozen=True, slots=True)
class Mark:
    """The paper's value for a scenario in a weather."""

    scenario: str
    weather: int
    value: float


def chart(dots: Sequence[Dot], marks: Sequence[Mark], label: str, ends: tuple[float, float] | None) -> Markup:
    """The SVG chart; `ends` of the axis, or None for automatic ends."""
    rows = list(dict.fromkeys((dot.scenario, dot.driver) for dot in dots))
    heads = list(dict.fromkeys(dot.scenario for dot in dots))
    low, high = ends or _ends(dots, marks)
    tall = HEAD * len(heads) + ROW * len(rows)
    plot = Plot(WIDTH, tall + FOOT, Axis(low, high, ticks=ticks(low, high, 5)), Axis(tall, 0.0, ticks=(-1.0,)))
    names = LETTER * max(len(_short(driver)) for _, driver in rows) + 14.0
    plot.margins = (names, 14.0, 0.0, FOOT)
    _rules(plot, tall)
    down = 0.0
    for scenario in heads:
        plot.text(scenario, 0.0, down + 14.0, "head")
        here = [driver for place, driver in rows if place == scenario]
        for mark in (mark for mark in marks if mark.scenario == scenario):
            _mark(plot, mark, down + 6.0, down + HEAD + ROW * len(here))
        down += HEAD
        for driver in here:
            plot.text(_short(driver), names - 8.0, down + 0.5 * ROW + 3.5, "label", "end")
            _row(plot, [dot for dot in dots if (dot.scenario, dot.driver) == (scenario, driver)], down + 0.5 * ROW)
            down += ROW
    return plot.svg(label)


def _short(name: str) -> str:
    """A name that fits: the end of a long one distinguishes files and classes."""
    return name if len(name) <= MOST_LETTERS else f"…{name[1 - MOST_LETTERS :]}"


def _ends(dots: Sequence[Dot], marks: Sequence[Mark]) -> tuple[float, float]:
    """Axis ends for all values and intervals."""
    values = [dot.value for dot in dots] + [end for dot in dots for end in dot.interval or ()]
    low, high = reach([0.0, *values, *(mark.value for mark in marks)], 0.1)
    return (0.0, high) if min(values) >= 0.0 else (low, high)


def _rules(plot: Plot, tall: float) -> None:
    for value in plot.x.ticks:
        plot.line(np.array([value, value]), np.array([0.0, tall]), "rule")
        px = float(plot.place(value, tall)[0])
        plot.text(f"{value:g}", px, tall + 13.0, "tick", "middle")


def _row(plot: Plot, dots: Sequence[Dot], middle: float) -> None:
    for number, dot in enumerate(sorted(dots, key=lambda dot: dot.weather)):
        y = middle + APART * (number - 0.5 * (len(dots) - 1))
        if dot.interval is not None:
            low, high = np.clip(dot.interval, plot.x.low, plot.x.high)
            plot.line(np.array([low, high]), np.array([y, y]), f"whisker {dot.style}")
        turned, hollow = MARKS[dot.weather % len(MARKS)]
        mark = plot.diamond if turned else plot.dot
        mark(float(np.clip(dot.value, plot.x.low, plot.x.high)), y, f"mark{' hollow' if hollow else ''} {dot.style}")


def _mark(plot: Plot, mark: Mark, top: float, bottom: float) -> None:
    value = float(np.clip(mark.value, plot.x.low, plot.x.high))
    plot.line(np.array([value, value]), np.array([top, bottom]), "paper" if mark.weather == 0 else "paper later")
