"""The page beside the paper's table."""

from vpf_sim.evaluation.analysis import reproduction
from vpf_sim.reporting import paper_page


def test_conditions_without_a_finished_drive_have_dashes() -> None:
    rows = reproduction.cells([])
    html = paper_page.page(paper_page.Findings("vpf-literal", rows, [], []), {})
    assert len(rows) == 4
    assert html.count('<td class="number">0 of 0</td>') == 4
    assert html.count("–</td>") == 4 * 5
