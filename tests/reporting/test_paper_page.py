"""The page beside the paper's table."""

from vpf_sim.evaluation.analysis import reproduction
from vpf_sim.reporting.templates import render


def test_conditions_without_a_finished_drive_have_dashes() -> None:
    rows = reproduction.cells([])
    html = render(
        "paper.html.jinja",
        driver="vpf-literal",
        cells=rows,
        definitions=[],
        claims=[],
        pictures={"paths": "", "flow": "", "forces": ""},
        signals=reproduction.SIGNALS,
    )
    assert len(rows) == 4
    assert html.count("<td>0 of 0</td>") == 4
    assert html.count("<td>-</td>") == 4 * 5
