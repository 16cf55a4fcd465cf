"""Whole frames are equal to the bit from every build of the core, and without the processor's newer instructions."""

import platform
import subprocess
from pathlib import Path

import pytest
from core_builds import HAS_GCC, build, printed

from building import compiler
from vpf_sim.envs.camera.core import _core

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
for camera in (Camera(84, 84), Camera(320, 240), Camera.of(424, 240, 105.0, pitch_rad=0.03, k1=-0.08, k2=0.01)):
    for name in WEATHERS:
        renderer, digest = Renderer(road, Rig(camera), weather.load(name), 5), sha256()
        for s in (2.0, 2.3, 9.0, 41.0, 70.0):
            position, heading = on_bend(s, 1.75)
            ego = SimpleNamespace(position=np.array(position), heading=heading)
            digest.update(renderer.render(ego, 0.1 * s).tobytes())
            if name == "ClearNoon":
                for array in renderer.truth(("depth", "instance")).values():
                    digest.update(array.tobytes())
        print(camera.width_px, name, digest.hexdigest())
"""
HELPERS = str(Path(__file__).parents[3] / "helpers")
PLAIN = {
    "NPY_DISABLE_CPU_FEATURES": "AVX2 FMA3 AVX512F AVX512CD AVX512_SKX",
    "OPENCV_CPU_DISABLE": "AVX2,FMA3",
    "OPENBLAS_CORETYPE": "Nehalem",
}
OTHERS = ["-O1", "-march=x86-64-v3"] if platform.machine() == "x86_64" else ["-O1"]


def frames(core: Path, weathers: tuple[str, ...], environment: dict[str, str] | None = None) -> str:
    code = f"import sys\nsys.path.insert(0, {HELPERS!r})\nWEATHERS = {weathers!r}\n"
    return printed(core, code + FRAMES, environment)


@HAS_GCC
@pytest.mark.parametrize("flag", OTHERS)
def test_frames_are_equal_from_other_builds(flag: str, tmp_path: Path) -> None:
    weathers = ("ClearNoon", "HardRainNoon", "ClearNight")
    assert frames(build(tmp_path, ["gcc", flag]), weathers) == frames(Path(_core.__file__), weathers)


@HAS_GCC
def test_checks_and_sanitizers_find_nothing_in_frames(tmp_path: Path) -> None:
    weathers = ("HardRainNoon", "ClearNight")
    core = build(tmp_path, ["gcc", *compiler.DEBUG, "-DVC_DEBUG"])
    names = ("libasan.so", "libubsan.so")  # the latter brings the C++ library, whose exceptions the former looks for
    libraries = [subprocess.check_output(["gcc", f"-print-file-name={name}"], text=True).strip() for name in names]
    if not all(Path(library).is_absolute() for library in libraries):
        pytest.skip("gcc comes without its sanitizers")
    environment = {"LD_PRELOAD": " ".join(libraries), "ASAN_OPTIONS": "detect_leaks=0"}
    assert frames(core, weathers, environment) == frames(Path(_core.__file__), weathers)


@pytest.mark.skipif(platform.machine() != "x86_64", reason="names instructions of x86-64")
def test_frames_are_equal_without_newer_instructions() -> None:
    weathers = ("ClearNoon", "HardRainNoon", "ClearNight")
    here = Path(_core.__file__)
    assert frames(here, weathers, PLAIN) == frames(here, weathers)
