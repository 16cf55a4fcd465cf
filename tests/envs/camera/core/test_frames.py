"""Frames and sums are equal to the bit from every build of the core, and its sanitizers find nothing."""

import platform
import subprocess
from pathlib import Path

import pytest
from core_builds import BITS, HAS_GCC, USE, build, installed, printed

from building import compiler

FRAMES = """
from hashlib import sha256
from types import SimpleNamespace
import numpy as np
from highway_scenes import add_object, bent_road, on_bend
from vpf_sim.envs.camera import Renderer, Rig, weather
from vpf_sim.types import Camera
road = bent_road()
for kind, s, right in (("car", 16.0, 3.5), ("van", 22.0, -3.5), ("truck", 45.0, 2.0), ("cone", 12.0, 0.5)):
    add_object(road, kind, *on_bend(s, right))
for camera in (Camera(84, 84), Camera(160, 120), Camera.of(212, 120, 105.0, pitch_rad=0.03, k1=-0.08, k2=0.01)):
    for name in WEATHERS:
        renderer, digest = Renderer(road, Rig(camera), weather.load(name), 5), sha256()
        for s in (2.0, 2.3, 41.0):
            position, heading = on_bend(s, 1.75)
            ego = SimpleNamespace(position=np.array(position), heading=heading)
            digest.update(renderer.render(ego, 0.1 * s).tobytes())
            if name == "ClearNoon":
                for array in renderer.truth(("depth", "instance")).values():
                    digest.update(array.tobytes())
        print(camera.width_px, name, digest.hexdigest())
"""
HELPERS = str(Path(__file__).parents[3] / "helpers")
OTHER = ["-Wall", "-Wextra", "-Werror", "-O1" if platform.machine() != "x86_64" else "-march=x86-64-v3"]


def frames(*weathers: str) -> str:
    """Code that prints hashes of frames in these weathers, and of the core's other results."""
    return f"import sys\nsys.path.insert(0, {HELPERS!r})\nWEATHERS = {weathers!r}\n{FRAMES}{USE}{BITS}"


@HAS_GCC
def test_another_build_computes_the_same(tmp_path: Path) -> None:
    code = frames("ClearNoon", "HardRainNoon", "ClearNight")
    assert printed(build(tmp_path, ["gcc", *OTHER]), code) == installed(code)


@HAS_GCC
def test_checks_and_sanitizers_find_nothing(tmp_path: Path) -> None:
    """Nor do frames differ without optimisation and without the compiler's own sines and cosines."""
    code = frames("ClearNoon", "HardRainNight")
    core = build(tmp_path, ["gcc", *compiler.DEBUG, "-O0", "-g0", "-fno-builtin", "-DVC_DEBUG"])
    names = ("libasan.so", "libubsan.so")  # the latter brings the C++ library, whose exceptions the former looks for
    libraries = [subprocess.check_output(["gcc", f"-print-file-name={name}"], text=True).strip() for name in names]
    if not all(Path(library).is_absolute() for library in libraries):
        pytest.skip("gcc comes without its sanitizers")
    environment = {"LD_PRELOAD": " ".join(libraries), "ASAN_OPTIONS": "detect_leaks=0"}
    assert printed(core, code, environment) == installed(code)
