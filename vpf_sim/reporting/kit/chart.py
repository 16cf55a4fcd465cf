"""Small hand-written SVG charts; colours come from the page's style sheet."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from html import escape
from math import ceil, floor, isfinite, log10

import numpy as np
from markupsafe import Markup

from vpf_sim.types import Floats

LEFT, RIGHT, TOP, BOTTOM = 42.0, 10.0, 10.0, 32.0  # margins of a plot, px
TICK = 30.0  # approximate px between ticks of a vertical axis
POINTS = 260  # of a line, after downsampling


@dataclass(frozen=True, slots=True)
class Figure:
    """A drawing with its caption."""

    caption: str
    svg: Markup


@dataclass(frozen=True, slots=True)
class Axis:
    """An axis from `low` (left or bottom) to `high`; low > high reverses it."""

    low: float
    high: float
    label: str = ""
    ticks: tuple[float, ...] = ()

    def share(self, value: Floats | float) -> Floats:
        """0 at low, 1 at high."""
        return (np.asarray(value, float) - self.low) / (self.high - self.low)


@dataclass(slots=True)
class Plot:
    """A plot to draw on; `svg` returns the result. Sizes are px at the page's text size."""

    width: float
    height: float
    x: Axis
    y: Axis
    margins: tuple[float, float, float, float] = (LEFT, RIGHT, TOP, BOTTOM)
    _parts: list[str] = field(default_factory=list)

    def place(self, x: Floats | float, y: Floats | float) -> Floats:
        """(..., 2) px of values."""
        left, right, top, bottom = self.margins
        across = left + self.x.share(x) * (self.width - left - right)
        down = self.height - bottom - self.y.share(y) * (self.height - top - bottom)
        return np.stack(np.broadcast_arrays(across, down), axis=-1)

    def line(self, x: Floats, y: Floats, style: str, closed: bool = False) -> None:
        """Draw a line through (N,) values, with gaps at nan."""
        for chain in _unbroken(self.place(x, y)):
            self._parts.append(f'<path class="{style}" d="{_path(chain, closed)}"/>')

    def signal(self, x: Floats, y: Floats, style: str) -> None:
        """Draw a line of many values, downsampled without losing peaks."""
        self.line(*thinned(x, y, POINTS // 2), style)

    def dot(self, x: float, y: float, style: str, radius: float = 4.0) -> None:
        px, py = self.place(x, y)
        self._parts.append(f'<circle class="{style}" cx="{px:.1f}" cy="{py:.1f}" r="{radius:g}"/>')

    def diamond(self, x: float, y: float, style: str, radius: float = 5.0) -> None:
        px, py = self.place(x, y)
        corners = np.array([(px, py - radius), (px + radius, py), (px, py + radius), (px - radius, py)])
        self._parts.append(f'<path class="{style}" d="{_path(corners, True)}"/>')

    def text(self, words: str, x_px: float, y_px: float, style: str = "label", anchor: str = "start") -> None:
        self._parts.append(
            f'<text class="{style}" x="{x_px:.1f}" y="{y_px:.1f}" text-anchor="{anchor}">{escape(words)}</text>'
        )

    def text_at(self, words: str, x: float, y: float, style: str = "label", anchor: str = "start") -> None:
        """Draw text at data coordinates."""
        px, py = self.place(x, y)
        self.text(words, float(px), float(py), style, anchor)

    def grid(self) -> None:
        """Draw grid lines, ticks and labels of both axes."""
        left, right, top, bottom = self.margins
        for value in self.x.ticks or ticks(self.x.low, self.x.high, 5):
            px = float(self.place(value, self.y.low)[0])
            self._rule(px, top, px, self.height - bottom)
            self.text(plain(value), px, self.height - bottom + 13.0, "tick", "middle")
        for value in self.y.ticks or ticks(self.y.low, self.y.high, max(4, int((self.height - top - bottom) / TICK))):
            py = float(self.place(self.x.low, value)[1])
            self._rule(left, py, self.width - right, py)
            self.text(plain(value), left - 5.0, py + 3.5, "tick", "end")
        self.text(self.x.label, self.width - right, self.height - 4.0, "axis", "end")
        self.text(self.y.label, 2.0, self.height - 4.0, "axis")

    def svg(self, meaning: str) -> Markup:
        """The SVG element; `meaning` is its description for screen readers."""
        size = f'viewBox="0 0 {self.width:g} {self.height:g}"'
        body = "".join(self._parts)
        return Markup(f'<svg {size} role="img" aria-label="{escape(meaning)}">{body}</svg>')

    def _rule(self, x1: float, y1: float, x2: float, y2: float) -> None:
        self._parts.append(f'<path class="rule" d="M{x1:.1f} {y1:.1f}L{x2:.1f} {y2:.1f}"/>')


def ticks(low: float, high: float, count: int) -> tuple[float, ...]:
    """Round tick values in [low, high], about `count` of them."""
    low, high = min(low, high), max(low, high)
    if not (isfinite(low) and isfinite(high)) or high <= low:
        return ()
    rough = (high - low) / count
    unit = 10.0 ** floor(log10(rough))
    step = unit * next(factor for factor in (1.0, 2.0, 5.0, 10.0) if factor * unit >= rough * (1.0 - 1e-9))
    first, last = ceil(low / step - 1e-9), floor(high / step + 1e-9)
    return tuple(round(step * number, 10) + 0.0 for number in range(first, last + 1))


def plain(value: float) -> str:
    """A tick label, with a true minus sign."""
    return f"{value:g}".replace("-", "−")


def thinned(x: Floats, y: Floats, bins: int) -> tuple[Floats, Floats]:
    """Minimum and maximum of each bin in order; all values if they are few."""
    if len(x) <= 2 * bins:
        return x, y
    chosen: set[int] = {0, len(x) - 1}
    for part in np.array_split(np.arange(len(x)), bins):
        finite = part[np.isfinite(y[part])]
        if len(finite):
            chosen |= {int(finite[np.argmin(y[finite])]), int(finite[np.argmax(y[finite])])}
        else:
            chosen.add(int(part[0]))
    index = sorted(chosen)
    return x[index], y[index]


def _unbroken(points: Floats) -> list[Floats]:
    """The pieces of a polyline between its gaps."""
    finite = np.all(np.isfinite(points), axis=1)
    edges = np.flatnonzero(np.diff(finite)) + 1
    return [piece for piece in np.split(points, edges) if len(piece) > 1 and np.all(np.isfinite(piece))]


def _path(points: Floats, closed: bool) -> str:
    """SVG path of relative moves with one decimal, without accumulating rounding errors."""
    whole = np.rint(np.clip(points, -1e4, 1e4) * 10.0).astype(int)
    steps = np.diff(whole, axis=0)
    steps = steps[np.any(steps != 0, axis=1)]
    moves = "".join(f"l{_tenth(dx)} {_tenth(dy)}" for dx, dy in steps.tolist())
    return f"M{_tenth(int(whole[0, 0]))} {_tenth(int(whole[0, 1]))}{moves}{'z' if closed else ''}"


def _tenth(number: int) -> str:
    return f"{number / 10:g}"


def legend_key(style: str) -> Markup:
    """A short line in a style, for a legend."""
    return Markup(f'<svg class="key" viewBox="0 0 26 10" aria-hidden="true"><path class="{style}" d="M2 5h22"/></svg>')


def reach(values: Sequence[float], least: float, margin: float = 0.08) -> tuple[float, float]:
    """The ends of an axis around values, at least `least` apart."""
    low, high = min(values), max(values)
    widen = max(0.5 * (least - (high - low)), margin * (high - low))
    return low - widen, high + widen
