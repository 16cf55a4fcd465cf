"""How the help of a command is laid out."""

from typing import Any

from typer.core import TyperCommand


class Command(TyperCommand):
    """A command whose help calls an argument by its metavar; typer adds the Python type, such as <str>."""

    def format_options(self, ctx: Any, formatter: Any) -> None:
        sections: dict[str, list[tuple[str, str]]] = {"argument": [], "option": []}
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx)
            if record is None:
                continue
            kind, (name, text) = parameter.param_type_name, record
            several = "..." if parameter.nargs != 1 else ""
            sections[kind].append((f"{parameter.metavar}{several}" if kind == "argument" else name, text))
        for kind, rows in sections.items():
            if rows:
                with formatter.section(f"{kind.capitalize()}s"):
                    formatter.write_dl(rows)
