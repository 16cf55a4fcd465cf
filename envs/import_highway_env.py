"""Import highway-env without pandas and matplotlib, which take two fifths of the time that a drive needs to start.

highway-env imports both at its beginning, for tables of observations and plots of a vehicle model. Our own roads need
neither. A placeholder stands for each of them meanwhile. It imports the module when something of it is used, as when
one of highway-env's environments is built.
"""

import sys
from importlib import import_module
from types import ModuleType
from typing import Any

LATER = ("pandas", "matplotlib", "matplotlib.pyplot")
EARLIER = ("gymnasium", "numpy", "pygame")  # what else highway-env imports, so that none of it meets a placeholder


class _Later(ModuleType):
    """A placeholder for a module, which is imported when something of it is used."""

    def __getattr__(self, name: str) -> Any:
        _remove(self)
        return getattr(import_module(self.__name__), name)


def _remove(placeholder: _Later) -> None:
    """Let the next import of the module be a real one."""
    if sys.modules.get(placeholder.__name__) is placeholder:
        del sys.modules[placeholder.__name__]


def _import_highway_env() -> None:
    for name in EARLIER:
        import_module(name)
    placeholders = {name: _Later(name) for name in LATER if name not in sys.modules}
    for name, placeholder in placeholders.items():
        package, _, module = name.rpartition(".")
        if package in placeholders:
            setattr(placeholders[package], module, placeholder)
    sys.modules.update(placeholders)
    try:
        import_module("highway_env")
    finally:
        for placeholder in placeholders.values():
            _remove(placeholder)


_import_highway_env()
