"""Make the notebooks of examples/ from its scripts: run them, and keep text and pictures.

python scripts/notebooks.py   # needs the extra docs

A script with lines "# %% Title" becomes a notebook: its docstring and the titles are text, all else is code. The first
cell of code installs the package, for a hosted notebook; here it is not run.
"""

import base64
import re
from pathlib import Path
from typing import Any

import cv2
import nbformat
import numpy as np
from nbclient import NotebookClient

EXAMPLES = Path(__file__).parents[1] / "examples"
CELL = re.compile(r"^# %% (.*)\n", re.MULTILINE)
QUALITY = 80  # of the pictures, JPEG
INSTALL = "%pip install --quiet 'vpf_sim[video]'  # in a checkout: '.[video]'"
NOT_RUN = "skip-execution"  # a tag that nbclient knows


def cells(script: str) -> list[tuple[str, str]]:
    """(kind, source) of the cells of a script: "markdown" or "code"."""
    docstring, *rest = CELL.split(script)
    found = [("markdown", docstring.strip().strip('"').strip())]
    for title, code in zip(rest[::2], rest[1::2], strict=True):
        found += [("markdown", f"## {title}"), ("code", code.strip())]
    return found


def executed(script: Path) -> nbformat.NotebookNode:
    """The notebook of a script, run from top to bottom."""
    new: dict[str, Any] = {"markdown": nbformat.v4.new_markdown_cell, "code": nbformat.v4.new_code_cell}
    made = [
        new[kind](source, id=f"cell-{number}") for number, (kind, source) in enumerate(cells(script.read_text("utf-8")))
    ]
    install = nbformat.v4.new_code_cell(INSTALL, id="install", metadata={"tags": [NOT_RUN]})
    notebook = nbformat.v4.new_notebook(cells=[made[0], install, *made[1:]])
    NotebookClient(notebook, kernel_name="python3", timeout=600).execute()
    for cell in notebook.cells:
        cell.metadata.clear()  # times
        for output in cell.get("outputs", ()):
            if "image/png" in output.get("data", {}):
                output["data"] = {"image/jpeg": as_jpeg(output["data"]["image/png"])}
    notebook.metadata = {"kernelspec": {"name": "python3", "display_name": "Python 3"}}
    return notebook


def as_jpeg(png: str) -> str:
    """A picture in base64, smaller."""
    image = cv2.imdecode(np.frombuffer(base64.b64decode(png), np.uint8), cv2.IMREAD_COLOR)
    assert image is not None
    return base64.b64encode(cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])[1].tobytes()).decode()


def main() -> None:
    for script in sorted(EXAMPLES.glob("*.py")):
        if CELL.search(script.read_text("utf-8")):
            nbformat.write(executed(script), script.with_suffix(".ipynb"))


if __name__ == "__main__":
    main()
