"""Other builds of the camera's core, and code that runs with one of them."""

import os
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import pytest

from building import compiler
from vpf_sim.envs.camera.core import SOURCES

FOLDER = Path(__file__).parents[2] / "envs" / "camera" / "core"
FILES = sorted(map(str, FOLDER.rglob("*.c")))
HAS_GCC = pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc")
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
