"""The fingerprint of code and machine: everything beside the inputs that an episode's bytes depend on."""

import json
import platform
import subprocess
from functools import cache
from hashlib import sha256
from importlib.util import find_spec
from pathlib import Path

PACKAGES = (
    "vpf_sim",
    "vpf_sim.controllers",
    "vpf_sim.envs",
    "vpf_sim.scenarios",
)  # a checkout maps some to other folders
SUFFIXES = (".py", ".toml", ".onnx")


def fingerprint() -> dict[str, str]:
    """Versions, the code's hash, and the CPU features that OpenCV uses in this process."""
    from importlib.metadata import version

    import cv2
    import numpy as np

    import vpf_sim

    return {
        "python": platform.python_version(),
        "numpy": np.__version__,
        "opencv": cv2.__version__,
        "opencv_cpu_features": cv2.getCPUFeaturesLine(),
        "highway_env": version("highway-env"),
        "vpf_sim": vpf_sim.__version__,
        "source": source(),
    }


@cache
def source() -> str:
    """SHA-256 over the files of the installed package and the C files of its core; any edit changes it."""
    from vpf_sim.envs.camera.core import SOURCES

    files = hash_of_files({package.replace(".", "/"): _folder(package) for package in PACKAGES})
    return sha256(f"{files} {SOURCES}".encode()).hexdigest()


def commit_of(sources: str) -> str | None:
    """The commit of this checkout, if these are its sources."""
    if sources != source():
        return None
    requested = ["git", "-C", str(_folder("vpf_sim")), "rev-parse", "--short", "HEAD"]
    try:
        return subprocess.run(requested, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return None


def own_code(driver: str) -> str | None:
    """SHA-256 of a user's driver, its outermost package or its variant file, or of a learned policy.

    None for other registered drivers, instances, and classes of a notebook or script.
    """
    from vpf_sim.drivers import VARIANT_PREFIX, is_importable, model_of
    from vpf_sim.planning import variant

    if (model := model_of(driver)) is not None:
        from vpf_sim.drivers.learned.driver import code

        return code(model)
    if driver.startswith(VARIANT_PREFIX):
        return sha256(repr(variant.load(driver.removeprefix(VARIANT_PREFIX))).encode()).hexdigest()
    if ":" not in driver or not is_importable(driver):
        return None
    return _code_of(driver.partition(":")[0].partition(".")[0])


@cache
def _code_of(package: str) -> str | None:
    """The hash of a package or module at the first call; None for one without files."""
    spec = find_spec(package)
    if spec is not None and spec.submodule_search_locations:
        return hash_of_files({f"{package}/{i}": Path(at) for i, at in enumerate(spec.submodule_search_locations)})
    return sha256(Path(spec.origin).read_bytes()).hexdigest() if spec is not None and spec.origin else None


def forget_code() -> None:
    """Read the code of drivers anew at the next fingerprint, as a run that begins does."""
    _code_of.cache_clear()


def hash_of_files(folders: dict[str, Path]) -> str:
    """SHA-256 over names and contents of code and configuration in `folders` (name -> folder)."""
    found = {
        f"{name}/{path.relative_to(folder).as_posix()}": path
        for name, folder in folders.items()
        for path in folder.rglob("*")
        if path.suffix in SUFFIXES and path.is_file()
    }
    lines = [f"{sha256(path.read_bytes()).hexdigest()} {name}\n" for name, path in sorted(found.items())]
    return sha256("".join(lines).encode()).hexdigest()


def _folder(package: str) -> Path:
    spec = find_spec(package)
    assert spec is not None
    assert spec.submodule_search_locations, f"{package} is a package"
    return Path(spec.submodule_search_locations[0])


def digest(value: object) -> str:
    """A short hash of a JSON value."""
    return sha256(json.dumps(value, sort_keys=True).encode()).hexdigest()[:16]
