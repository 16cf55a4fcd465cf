"""Sphinx builds the documentation from the pages in this folder and from docstrings: `make docs`."""

import sys
import typing
from pathlib import Path

import typer.main
from pygments.lexers.special import TextLexer
from sphinx.highlighting import lexers
from typer.cli import get_docs_for_click

import vpf_sim
import vpf_sim.cli

HERE = Path(__file__).parent
sys.path.append(str(HERE))

project = "vpf_sim"
author = "the vpf_sim developers"
version = release = vpf_sim.__version__
extensions = ["myst_parser", "sphinx.ext.autodoc"]
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
html_title = f"vpf_sim {version}"


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


write_commands()
write_configuration()
