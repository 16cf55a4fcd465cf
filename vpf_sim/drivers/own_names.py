"""What a user meant by a file or a module in the place of "package.module:Class"."""

import ast
import re
import sys
from pathlib import Path

NAME = re.compile(r"(?P<place>(?:[A-Za-z]:/)?[^:]+?)(?P<ending>\.py)?(?::+(?P<kind>\w*))?")  # "C:/" is a drive
INIT = "__init__"  # the file of a package
MOST_LISTED = 3  # classes in a message
FORM = "expected package.module:Class"


def remedy(name: str) -> str | None:
    """The end of a message: what to write instead; None where nothing better is known."""
    written = NAME.fullmatch(name.replace("\\", "/"))
    if written is None:
        return None
    place, kind = written["place"], written["kind"] or ""
    is_file = bool(written["ending"]) or "/" in place
    source = _source(place)
    if source is None and not is_file and not kind:  # "student.Student"
        place, _, kind = place.rpartition(".")
        source = _source(place)
    if source is None:
        return f"{FORM}, got a file that was not found" if is_file else None
    kinds = driver_classes(source)
    if not (kinds or is_file or source.parent == Path.cwd()):  # a module of a library
        return None
    folder, module = _module(source)
    meant = [f"{module}:{one}" for one in ([kind] if kind in kinds else kinds or [kind or "CLASS"])]
    if name in meant:
        return None
    where = "" if folder in _search_path() else f", with {folder} in PYTHONPATH"
    got = f"{FORM}, got a file; " if is_file else "" if ":" in name else f"{FORM}, got a module; "
    return f"{got}write {' or '.join(meant[:MOST_LISTED])}{where}"


def driver_classes(source: Path) -> list[str]:
    """The classes of a source file that have `act` or are derived from a driver; the file is not run."""
    try:
        tree = ast.parse(source.read_bytes())
    except (OSError, ValueError, SyntaxError):
        return []
    return [item.name for item in tree.body if isinstance(item, ast.ClassDef) and _is_driver(item)]


def _is_driver(item: ast.ClassDef) -> bool:
    has_act = any(isinstance(part, ast.FunctionDef) and part.name == "act" for part in item.body)
    return has_act or any(ast.unparse(base).endswith("Driver") for base in item.bases)


def _search_path() -> list[Path]:
    """The folders in which modules are looked for."""
    return [Path(entry or ".").resolve() for entry in sys.path]


def _source(place: str) -> Path | None:
    """The source file of a module or of a path without its ending."""
    relative = place if "/" in place else place.replace(".", "/")
    for folder in (Path.cwd(), *_search_path()):
        for file in (folder / f"{relative}.py", folder / relative / f"{INIT}.py"):
            if place and file.is_file():
                return file.resolve()
    return None


def _module(source: Path) -> tuple[Path, str]:
    """The folder in which a source file can be found as a module, and the module's name."""
    folders = (Path.cwd(), *_search_path())
    folder = next((folder for folder in folders if source.is_relative_to(folder)), source.parent)
    parts = source.relative_to(folder).with_suffix("").parts
    return folder, ".".join(part for part in parts if part != INIT)
