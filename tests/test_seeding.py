"""Streams are named, independent and the same everywhere."""

import subprocess
import sys

from vpf_sim.seeding import stream


def test_streams_differ_by_name_and_seed() -> None:
    draws = {stream(seed, name).integers(2**62) for seed in (0, 1) for name in ("road", "noise")}
    assert len(draws) == 4


def test_the_same_draw_in_a_fresh_process() -> None:
    code = "from vpf_sim.seeding import stream; print(stream(1003, 'road').integers(2**62))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert int(done.stdout) == stream(1003, "road").integers(2**62)
