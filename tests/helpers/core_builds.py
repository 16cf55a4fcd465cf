"""Other builds of the camera's core, and code that runs with one of them."""

import os
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import pytest

from building import compiler
from vpf_sim.envs.camera.core import SOURCES, _core

FOLDER = Path(__file__).parents[2] / "envs" / "camera" / "core"
FILES = sorted(map(str, FOLDER.rglob("*.c")))
HAS_GCC = pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc")
# What the core computes, as hashes: rain and reflections; sines and cosines.
USE = f"""
import sys
from hashlib import sha256
import numpy as np
sys.path.append({str(Path(__file__).parent)!r})
from wet_scene import WetScene
from vpf_sim.types import Camera
for name in ("WetNoon", "HardRainNoon"):
    scene = WetScene(Camera(161, 121, 80.0, 80.0, 80.0, 60.0), name, 9.0)
    for k in range(5):
        print(sha256(scene.draw(0.3 * k, 14.0).tobytes() + scene.hidden().tobytes()).hexdigest())
angles, result = np.linspace(-9.0, 9.0, 1001), np.empty(1001)
module.sin(angles, result)
module.cos(angles, result)
print(result.sum().hex(), module.hypot(3.0, 4.0))
for width, height in ((84, 84), (161, 121), (9, 5)):
    frame, hidden = np.zeros((height, width, 3), np.uint8), np.zeros((height, width), np.uint8)
    lens = width, height, 0.5 * width, 0.5 * width, 0.5 * width, 0.5 * height
    streaks = module.streaks_new(lens, 0.03, 50.0, 0.002, 170.0, 8.0, 7)
    glass = module.glass_new(lens, 50.0, 0.92, 0.3, (150, 160, 170), 7)
    for k in range(0, 200, 3):
        frame[:] = np.arange(frame.size).reshape(frame.shape)
        module.streaks_draw(streaks, (-0.1 * k, 3.0, 0.0), 0.02 * k, 16667 * k, frame)
        module.glass_advance(glass, 16667 * k, float(k % 30))
        module.glass_draw(glass, frame)
        module.glass_hidden(glass, hidden)
        print(sha256(frame.tobytes() + hidden.tobytes()).hexdigest())
"""
BITS = """
from hashlib import sha256
import numpy as np
angles = np.concatenate([np.linspace(-50.0, 50.0, 200_001), np.random.default_rng(2).uniform(-1e6, 1e6, 200_000)])
result = np.empty((2, len(angles)))
module.sin(angles, result[0])
module.cos(angles, result[1])
print(sha256(result.tobytes()).hexdigest())
"""
PRELUDE = """
import importlib.util, sys
spec = importlib.util.spec_from_file_location("vpf_sim.envs.camera.core._core", {core!r})
module = importlib.util.module_from_spec(spec)
spec.loader.exec_module(module)
sys.modules[spec.name] = module
"""


def build(folder: Path, command: Sequence[str]) -> Path:
    """The core as a compiler makes it with these flags after those of every build."""
    target = folder / "_core.abi3.so"
    given = [
        f"-DVC_SOURCES={SOURCES}",
        "-DPy_LIMITED_API=0x030B0000",
        f"-I{FOLDER}",
        f"-I{compiler.HEADERS}",
        "-fPIC",
        "-shared",
    ]
    first, *flags = command
    done = subprocess.run(
        [first, *compiler.FLAGS, *given, *flags, *FILES, "-lm", "-o", str(target)], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return target


def printed(core: Path, code: str, environment: Mapping[str, str] | None = None) -> str:
    """What code prints in a process of its own, with that build in place of the installed one."""
    command = [sys.executable, "-c", PRELUDE.format(core=str(core)) + code]
    done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, **(environment or {})})
    assert done.returncode == 0, done.stderr
    return done.stdout


def installed(code: str) -> str:
    """What code prints with the core in use, which is that of this process."""
    out = StringIO()
    with redirect_stdout(out):
        exec(code, {"module": _core})
    return out.getvalue()
