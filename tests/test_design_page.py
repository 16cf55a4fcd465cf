"""The design page names what exists, all stages of the pipelines, and shows their figure as it is drawn now."""

import re
import runpy
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "design.md").read_text("utf-8")
FIGURE = runpy.run_path(str(ROOT / "scripts" / "figures" / "pipeline_figure.py"))
MOST_WORDS = 3000


def test_the_committed_figure_is_what_the_script_draws() -> None:
    committed = (ROOT / "docs" / "pictures" / "pipeline.svg").read_text("utf-8")
    assert committed == FIGURE["picture"](), "draw it again: python scripts/figures/pipeline_figure.py"


def test_every_stage_has_a_row() -> None:
    rows = re.findall(r"^\| `(\w+)` \|", PAGE, re.MULTILINE)
    stages = {stage.name for name in ("paper", "robust") for stage in FIGURE["stages"](name)}
    assert stages <= set(rows)


def test_named_files_and_folders_exist() -> None:
    paths = re.findall(r"`([\w.-]+/[\w./-]*)`", PAGE)
    assert paths
    assert [path for path in paths if not (ROOT / path).exists()] == []


def test_the_page_stays_short() -> None:
    assert len(PAGE.split()) <= MOST_WORDS
