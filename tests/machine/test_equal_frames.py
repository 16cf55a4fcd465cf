"""Frames are those of the table on any processor, with any libraries' code for it.

Hashes of the table are recorded from our own frames: they are no truth about what a frame shows, but a promise that all
machines show the same.
"""

import os
import platform
import subprocess
import sys
from itertools import product

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


def test_frames_are_those_of_the_table() -> None:
    assert dict(equal_frames.drawn()) == equal_frames.expected(), CHANGED


@pytest.mark.skipif(platform.machine() != "x86_64", reason="names instructions of x86-64")
@pytest.mark.parametrize("road", ROADS[1:])
def test_an_old_processor_draws_the_same_frames(road: str) -> None:
    code = f"from vpf_sim.machine import equal_frames as e; print(dict(e.drawn(({road!r},), sizes=e.SIZES[1:])))"
    environment = {**os.environ, **OLD_PROCESSOR}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment, check=True)
    table = {name: digest for name, digest in equal_frames.expected().items() if name.split()[0] == road}
    assert done.stdout.strip() == str({name: digest for name, digest in table.items() if not name.endswith("84x84")})


def test_the_doctor_names_what_differs(monkeypatch: pytest.MonkeyPatch) -> None:
    assert equal_frames.check().ok
    table = equal_frames.expected() | {"town04 WetNoon 84x84": "0" * 64}
    monkeypatch.setattr(equal_frames, "expected", lambda: table)
    check = equal_frames.check()
    assert (check.ok, check.found) == (False, "1 of 5 differ: town04 WetNoon 84x84")
