"""Draw docs/pictures/pipeline.svg: the stages of both pipelines and the fields that they read and write."""

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path
from xml.sax.saxutils import escape

from vpf_sim.driver_interface import DriverSetup
from vpf_sim.drivers.paper_pipeline import FEEDBACK, INPUTS
from vpf_sim.drivers.perceiver import Perceiver
from vpf_sim.pipeline import Stage
from vpf_sim.planning import variant
from vpf_sim.types import Camera, VehicleModel

PICTURE = Path(__file__).parents[2] / "docs" / "pictures" / "pipeline.svg"
SETUP = DriverSetup(Camera(), VehicleModel(), 60.0, 5.55, (100.0, 0.0), seed=0)
LEFT, TOP, ROW, COLUMN, BOX, BOTTOM = 16, 124, 26, 30, 170, 80
INK, FAINT, COMMON, ROBUST = "#222", "#999", "#d6e6f5", "#fbe3c4"
STYLE = f"""text {{ font: 12px sans-serif; fill: {INK}; }}
.input {{ stroke: {FAINT}; fill: none; }}
.field {{ stroke: {INK}; fill: none; }}
.feedback {{ stroke: #b03020; fill: none; stroke-dasharray: 5 3; }}
.reads {{ fill: #fff; stroke: {INK}; }}
.writes {{ fill: {INK}; stroke: {INK}; }}"""


def stages(name: str) -> Sequence[Stage]:
    """The stages of a variant's pipeline."""
    return Perceiver(SETUP, variant.load(name)).pipeline.stages


def picture() -> str:
    """The figure as SVG: a row for each stage of the robust pipeline, a column for each field."""
    rows, common = stages("robust"), {stage.name for stage in stages("paper")}
    columns = list(dict.fromkeys([*INPUTS.split(), *(name for stage in rows for name in stage.writes)]))
    width = LEFT + BOX + COLUMN * (len(columns) + 2)
    height = TOP + ROW * len(rows) + BOTTOM
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" role="img">',
        "<title>Stages of the two perception pipelines, and the fields that they read and write</title>",
        f"<style>{STYLE}</style>",
        f'<rect width="{width}" height="{height}" fill="#fff"/>',
        *(part for i, stage in enumerate(rows) for part in _box(i, stage.name, stage.name in common)),
        *(part for i, field in enumerate(columns) for part in _column(i, field, rows)),
        *_legend(TOP + ROW * len(rows) + 24),
        "</svg>",
    ]
    return "\n".join(parts) + "\n"


def _box(row: int, name: str, is_common: bool) -> Iterator[str]:
    y = TOP + ROW * row
    yield f'<rect x="{LEFT}" y="{y}" width="{BOX}" height="{ROW - 6}" rx="4" fill="{COMMON if is_common else ROBUST}"/>'
    yield f'<text x="{LEFT + 8}" y="{y + 14}">{escape(name)}</text>'


def _column(column: int, field: str, rows: Sequence[Stage]) -> Iterator[str]:
    """A field's name, its line from where it is set to its last reader, and a mark at each stage that uses it."""
    x = LEFT + BOX + COLUMN * (column + 1)
    readers = [i for i, stage in enumerate(rows) if field in stage.reads]
    writers = [i for i, stage in enumerate(rows) if field in stage.writes]
    yield f'<text transform="translate({x + 4} {TOP - 12}) rotate(-60)">{escape(field)}</text>'
    if field in INPUTS.split():
        yield _stroke("input", x, TOP - 6, _middle(max(readers)))
    else:
        yield _stroke("field", x, _middle(writers[0]), _middle(max([*readers, *writers])))
    if field in FEEDBACK.split():
        yield _stroke("feedback", x, TOP - 6, _middle(writers[0]))
    for kind, marked in (("reads", readers), ("writes", writers)):
        for i in marked:
            radius = 4 if kind == "reads" or i not in readers else 2
            yield f'<circle class="{kind}" cx="{x}" cy="{_middle(i)}" r="{radius}"/>'


def _stroke(kind: str, x: int, top: int, bottom: int) -> str:
    return f'<path class="{kind}" d="M{x} {top}V{bottom}"/>'


def _middle(row: int) -> int:
    return TOP + ROW * row + (ROW - 6) // 2


def _legend(y: int) -> Iterator[str]:
    for x, colour, words in ((LEFT, COMMON, "both pipelines"), (LEFT + 150, ROBUST, "robust pipeline only")):
        yield f'<rect x="{x}" y="{y}" width="16" height="12" fill="{colour}"/>'
        yield f'<text x="{x + 22}" y="{y + 11}">{words}</text>'
    for x, kind, words in ((LEFT + 330, "reads", "reads"), (LEFT + 410, "writes", "writes")):
        yield f'<circle class="{kind}" cx="{x}" cy="{y + 6}" r="4"/>'
        yield f'<text x="{x + 10}" y="{y + 11}">{words}</text>'
    for x, kind, words in (
        (LEFT, "input", "set before the frame"),
        (LEFT + 180, "field", "written in this frame"),
        (LEFT + 370, "feedback", "from the last frame"),
    ):
        yield f'<path class="{kind}" d="M{x} {y + 34}h24"/>'
        yield f'<text x="{x + 30}" y="{y + 38}">{words}</text>'


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=PICTURE, help="file to write")
    parser.parse_args().out.write_text(picture(), "utf-8")
