"""Sphinx builds the documentation from the pages in this folder and from docstrings: `make docs`."""

import sys
import typing
from pathlib import Path

import typer.main
from pygments.lexers.special import TextLexer
from sphinx.application import Sphinx
from sphinx.highlighting import lexers
from typer.cli import get_docs_for_click

import vpf_sim
import vpf_sim.cli

HERE = Path(__file__).parent
sys.path.append(str(HERE))

project = "vpf_sim"
author = "the vpf_sim developers"
version = release = vpf_sim.__version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx_copybutton"]
exclude_patterns: list[str] = []

myst_heading_anchors = 4  # the names that GitHub gives to headings
default_role = "literal"  # single backquotes in docstrings are code, as in the pages
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
python_maximum_signature_line_length = 88
autodoc_preserve_defaults = True

smartquotes = False  # options begin with two hyphens
lexers["csv"] = TextLexer()

html_theme = "furo"
html_show_copyright = False
html_show_sourcelink = False  # its icon stands over the title on a phone
html_title = f"vpf_sim {version}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
MOVED = {  # pages of earlier versions, and where their text is now
    "cluster": "sweeps.html#on-many-machines",
    "play": "start.html#drive-yourself",
    "readings": "reproduce.html#which-settings-does-the-paper-leave-open",
    "sensor-faults": "weather.html#sensor-faults",
    "town04": "reproduce.html#all-drivers-on-the-papers-road",
}


def write_commands() -> None:
    """The page of the command line, from the program itself."""
    command = typer.main.get_command(vpf_sim.cli.app)
    context = typing.cast(typing.Any, command).make_context("vpf-sim", ["--help"], resilient_parsing=True)
    text = get_docs_for_click(obj=command, ctx=context, name="vpf-sim", title="Command line")
    (HERE / "commands.md").write_text(text, "utf-8")


def write_configuration() -> None:
    """The page of all keys, from the classes that the files fill."""
    import configuration_page

    (HERE / "configuration.md").write_text(configuration_page.page(), "utf-8")


def write_moved(app: Sphinx, error: Exception | None) -> None:
    """Pages that lead old addresses to their text."""
    for name, target in MOVED.items() if error is None else ():
        (Path(app.outdir) / f"{name}.html").write_text(
            f'<meta http-equiv="refresh" content="0; url={target}">', "utf-8"
        )


def setup(app: Sphinx) -> None:
    """What Sphinx calls before it builds."""
    app.connect("build-finished", write_moved)


write_commands()
write_configuration()
