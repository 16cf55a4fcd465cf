"""The core built by another compiler and for another processor, and one that is out of date."""

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from core_builds import FILES, FOLDER, HAS_GCC, USE, build, installed, printed
from recorded_calls import recorded

from building import compiler
from vpf_sim.machine import equal_frames

ROOT = Path(__file__).parents[4]
REPLAY = str(ROOT / "tests" / "helpers" / "replay.c")
CROSS = "aarch64-linux-gnu-gcc"


def output(command: list[str]) -> str:
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


@HAS_GCC
def test_a_core_older_than_its_c_files_is_refused(tmp_path: Path) -> None:
    core = build(tmp_path, ["gcc", "-O0", "-UVC_SOURCES", "-DVC_SOURCES=older"])
    code = "try:\n    import vpf_sim.envs.camera.core\nexcept ImportError as error:\n    print(error)"
    assert "older than its C files: run `make core`" in printed(core, code)


def replayed(command: list[str], emulator: list[str], calls: Path) -> list[str]:
    """The checksums of recorded calls from a program that a compiler makes without Python."""
    program = calls.with_suffix(f".{command[0]}")
    flags = [*compiler.FLAGS, "-DVC_SOURCES=replayed", f"-I{FOLDER}", f"-I{compiler.HEADERS}"]
    subprocess.run([*command, *flags, REPLAY, *FILES, "-lm", "-o", str(program)], check=True)
    with calls.open("rb") as source:
        done = subprocess.run([*emulator, str(program)], stdin=source, capture_output=True, text=True, check=True)
    return done.stdout.splitlines()


@pytest.mark.slow
@HAS_GCC
@pytest.mark.skipif(shutil.which(CROSS) is None, reason=f"needs {CROSS} (Debian: gcc-aarch64-linux-gnu)")
@pytest.mark.skipif(shutil.which("qemu-aarch64") is None, reason="needs qemu-aarch64 (Debian: qemu-user)")
def test_aarch64_draws_the_same_frames(tmp_path: Path) -> None:
    """All calls that draw the doctor's frames, with the content that they got here."""
    calls = tmp_path / "calls"
    with calls.open("wb") as out, recorded(out) as recorder:
        drawn = dict(equal_frames.drawn(*equal_frames.QUICK))
    assert drawn.items() <= equal_frames.expected().items()
    assert len({line for line in recorder.checksums if "draw" in line}) > 60
    assert replayed([CROSS, "-static"], ["qemu-aarch64"], calls) == recorder.checksums
    assert replayed(["gcc"], [], calls) == recorder.checksums


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="hides the compiler by an empty PATH")
def test_a_machine_without_a_compiler_gets_one_from_the_package_index(tmp_path: Path) -> None:
    """pip builds in isolation; the wheel's core computes what the one in use does."""
    source = tmp_path / "source"
    tracked = output(["git", "-C", str(ROOT), "ls-files", "-co", "--exclude-standard"]).splitlines()
    for name in tracked:
        (source / name).parent.mkdir(parents=True, exist_ok=True)
        if (ROOT / name).is_file():
            shutil.copy(ROOT / name, source / name)
    command = [sys.executable, "-m", "pip", "wheel", "--no-deps", "--wheel-dir", str(tmp_path / "wheels"), str(source)]
    alone = {key: value for key, value in os.environ.items() if key != "CC"} | {"PATH": str(tmp_path)}
    done = subprocess.run(command, capture_output=True, text=True, env=alone, check=False)
    if "No matching distribution" in done.stderr + done.stdout:
        pytest.skip("no package index can be reached")
    assert done.returncode == 0, done.stderr
    (wheel,) = (tmp_path / "wheels").glob("*-cp311-abi3-*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extract("vpf_sim/envs/camera/core/_core.abi3.so", tmp_path)
    core = tmp_path / "vpf_sim" / "envs" / "camera" / "core" / "_core.abi3.so"
    assert printed(core, USE) == installed(USE)
    quick = "from vpf_sim.machine.equal_frames import QUICK, drawn, expected\n"
    assert printed(core, f"{quick}print(dict(drawn(*QUICK)).items() <= expected().items())") == "True\n"
