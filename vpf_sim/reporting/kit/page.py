"""Pages from templates, with one style sheet and one set of macros; a page is one file that loads nothing."""

from typing import Any

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from vpf_sim.reporting.kit.chart import legend_key

KIT = "vpf_sim.reporting.kit"


def render(template: str, package: str = "vpf_sim.reporting", **content: Any) -> str:
    """A page of a package's template; `style` is the style sheet, `key` draws a legend's line."""
    loader = ChoiceLoader([PackageLoader(KIT, ""), PackageLoader(package, "")])
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True, loader=loader
    )
    environment.globals["key"] = legend_key
    style = Markup(environment.get_template("page.css.jinja").render())
    return environment.get_template(template).render(style=style, **content)
