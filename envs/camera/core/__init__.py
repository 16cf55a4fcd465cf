"""The camera's core in C; the headers beside this file state its contracts."""

from pathlib import Path

from vpf_sim.envs.camera.core.sources import digest

BUILD = "run `make core`, or `pip install --editable .` again"

try:
    from vpf_sim.envs.camera.core._core import SOURCES
except ImportError as error:
    raise ImportError(f"the camera's core is not built: {BUILD} ({error})") from error
if digest(Path(__file__).parent) not in ("", SOURCES):  # a wheel has no C files
    raise ImportError(f"the camera's core is older than its C files: {BUILD}")

__all__ = ["SOURCES"]
