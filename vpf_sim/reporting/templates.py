"""Pages from templates, with the style sheet and the macros that they share."""

from typing import Any

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from vpf_sim.reporting.cells import shown
from vpf_sim.reporting.chart import legend_key

OWN = "vpf_sim.reporting"


def render(template: str, package: str = OWN, **content: Any) -> str:
    """A page of a package's template; `style` is the style sheet, `key` draws a legend's line."""
    loader = ChoiceLoader([PackageLoader(OWN, ""), PackageLoader(package, "")])
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True, loader=loader
    )
    environment.globals["key"] = legend_key
    environment.filters["shown"] = shown
    style = Markup(environment.get_template("report.css.jinja").render())
    return environment.get_template(template).render(style=style, **content)
