"""Frames are those of the table on any processor, with any libraries' code for it.

Hashes of the table are recorded from our own frames: they are no truth about what a frame shows, but a promise that all
machines show the same.
"""

import os
import platform
import subprocess
import sys
from itertools import product
from pathlib import Path

import pytest

from vpf_sim.machine import equal_frames
from vpf_sim.machine.equal_frames import CAMERAS, ROADS, SIZES, WEATHERS

CHANGED = "frames differ; if this was meant, run `python scripts/frame_hashes.py` and say so in the changelog"
# Without what numpy, OpenCV, the BLAS library and the C library do with newer instructions of x86-64.
OLD_PROCESSOR = {
    "NPY_DISABLE_CPU_FEATURES": "X86_V3 X86_V4 AVX512_ICL",
    "OPENCV_CPU_DISABLE": "AVX2,FMA3",
    "OPENBLAS_CORETYPE": "Prescott",
    "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-AVX2_Usable,-FMA_Usable,-AVX512F",
}


def test_the_table_has_all_combinations() -> None:
    pictures = [*(f"{width}x{height}" for width, height in SIZES), *CAMERAS]
    names = {" ".join(parts) for parts in product(ROADS, WEATHERS, pictures)}
    assert set(equal_frames.expected()) == names


def by_turns() -> dict[str, str]:
    """Hashes of the frames of each road in each weather, by one size or camera, of which each has its turn."""
    found: dict[str, str] = {}
    for number, (road, weather) in enumerate(product(ROADS, WEATHERS)):
        turn = number % (len(SIZES) + len(CAMERAS))
        sizes, cameras = SIZES[turn : turn + 1], CAMERAS[max(turn - len(SIZES), 0) :][: int(turn >= len(SIZES))]
        found |= equal_frames.drawn((road,), (weather,), sizes, cameras)
    return found


def test_frames_are_those_of_the_table() -> None:
    found = by_turns()
    assert len(found) == len(ROADS) * len(WEATHERS)
    assert found == {name: equal_frames.expected()[name] for name in found}, CHANGED


@pytest.mark.slow
def test_all_frames_are_those_of_the_table() -> None:
    assert dict(equal_frames.drawn()) == equal_frames.expected(), CHANGED


@pytest.mark.skipif(platform.machine() != "x86_64", reason="names instructions of x86-64")
def test_an_old_processor_draws_the_same_frames() -> None:
    code = "import test_equal_frames as tests; tests.test_frames_are_those_of_the_table()"
    environment = {**os.environ, **OLD_PROCESSOR}
    command, folder = [sys.executable, "-c", code], Path(__file__).parent
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, done.stderr


def test_the_doctor_names_what_differs(monkeypatch: pytest.MonkeyPatch) -> None:
    assert equal_frames.check().ok
    table = equal_frames.expected() | {"town04 WetNoon 84x84": "0" * 64}
    monkeypatch.setattr(equal_frames, "expected", lambda: table)
    check = equal_frames.check()
    assert (check.ok, check.found) == (False, "1 of 5 differ: town04 WetNoon 84x84")
