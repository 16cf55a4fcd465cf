"""Users' own drivers: by "package.module:Class", as a class, or as an instance."""

import ast
import re
import sys
from importlib import import_module
from inspect import signature
from pathlib import Path
from typing import Protocol, TypeAlias, cast, get_args

from vpf_sim import process_state
from vpf_sim.driver_interface import Command, Driver, DriverSetup, Observation, Privilege
from vpf_sim.errors import InputError, shown

PARTS = ("privileged", "reset", "act")
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


class OwnDriver(Protocol):
    """The three members that a class needs to be a driver; `vpf_sim.Driver` has more, with defaults."""

    @property
    def privileged(self) -> str:
        """ "none", "route" or "world"."""
        ...

    def reset(self, setup: DriverSetup) -> None:
        """Begin an episode."""
        ...

    def act(self, observation: Observation) -> Command:
        """The command at one step."""
        ...


DriverLike: TypeAlias = str | OwnDriver | type[OwnDriver]

_KEPT: dict[str, object] = {}  # classes and instances that are found by no import, by the name in their records


def name_of(driver: DriverLike) -> str:
    """The driver's name in records: "module:Class" of a class, "module:Class()" of an instance."""
    if isinstance(driver, str):
        return driver
    own = process_state.unwrapped(driver)
    kind = own if isinstance(own, type) else type(own)
    name = f"{kind.__module__}:{kind.__qualname__}"
    return name if own is kind else f"{name}()"


def admit(name: str, driver: DriverLike) -> None:
    """Let `create(name)` make this driver: a class or instance that no name leads to is kept while the process lives.

    Of a class that can be imported, nothing is kept: its module may be loaded anew.
    """
    if name == name_of(driver) and is_importable(driver):
        _KEPT.pop(name, None)
    elif name != driver:
        _KEPT[name] = driver


def is_kept(name: str) -> bool:
    """Whether `admit` kept a driver by this name."""
    return name in _KEPT


def is_importable(driver: DriverLike) -> bool:
    """Whether other processes find the driver by its name: not an instance, nor a class of a notebook or script."""
    if isinstance(driver, str):
        is_own_here = driver.startswith("__main__:") or driver.endswith("()") or "<locals>" in driver
        return not is_own_here and not is_kept(driver)
    if not isinstance(driver, type):
        return False
    module = sys.modules.get(driver.__module__)
    return driver.__module__ != "__main__" and getattr(module, driver.__qualname__, None) is driver


def make(driver: object, name: str) -> Driver:
    """The driver of a class or instance, checked against the protocol; InputError where it is none."""
    own = process_state.unwrapped(driver)
    own = _instance(own, name) if isinstance(own, type) else own
    missing = [part for part in PARTS if not hasattr(own, part) or _is_placeholder(own, part)]
    if missing:
        raise InputError(f"driver '{name}': expected privileged, reset and act; missing: {', '.join(missing)}")
    for part, argument in (("reset", "setup"), ("act", "observation")):
        if not _takes_one(getattr(own, part)):
            raise InputError(f"driver '{name}': expected a method {part}({argument}), got {_written(own, part)}")
    made = cast(Driver, process_state.Isolated(own))
    if made.privileged not in get_args(Privilege):
        raise InputError(f"driver '{name}': privileged: expected none, route or world, got {made.privileged!r}")
    return made


def _is_placeholder(own: object, part: str) -> bool:
    """Whether the method is that of the base class, which has no body."""
    return part == "act" and getattr(own.act, "__func__", None) is Driver.act  # type: ignore[attr-defined]


def _takes_one(method: object) -> bool:
    """Whether a method can be called with one argument; True where that is not known."""
    if not callable(method):
        return False
    try:
        signature(method).bind(None)
    except TypeError:
        return False
    except ValueError:  # no signature, as of some built-in functions
        return True
    return True


def _written(own: object, part: str) -> str:
    """A member as its class has it: "act(one, two)"."""
    member = getattr(own, part)
    return f"{part}{signature(member)}" if callable(member) else f"{part} = {shown(member)}"


def load(name: str) -> Driver:
    """A driver of the class at "package.module:Class", or the one that is kept under this name."""
    return make(_KEPT[name] if name in _KEPT else _class_at(name), name)


def _class_at(name: str) -> type:
    module_name, _, class_name = name.partition(":")
    try:
        with process_state.preserved():
            module = import_module(module_name)
    except (ImportError, ValueError) as error:
        fault = remedy(name) or f"cannot import '{module_name}': {error}"
        raise InputError(f"driver '{name}': {fault}") from error
    except Exception as error:
        fault = remedy(name) or f"importing '{module_name}' raised {_one_line(error)}"
        raise InputError(f"driver '{name}': {fault}") from error
    found = getattr(module, class_name, None)
    if not isinstance(found, type):
        fault = f"module '{module_name}' has no class '{class_name}'"
        hint = remedy(name)
        raise InputError(f"driver '{name}': {fault}" + (f"; {hint}" if hint else ""))
    return found


def _instance(kind: type, name: str) -> object:
    try:
        with process_state.preserved():
            return kind()
    except TypeError as error:
        raise InputError(f"driver '{name}': expected a class that is made without arguments: {error}") from error
    except Exception as error:
        raise InputError(f"driver '{name}': making it raised {_one_line(error)}") from error


def _one_line(error: Exception) -> str:
    """An exception of a user's own code in one line; the exception itself is chained."""
    return " ".join(f"{type(error).__name__}: {error}".split())
