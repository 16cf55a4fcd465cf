"""The C compiler: the system's, or else zig's from the package index."""

import os
import shlex
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path

WINDOWS = os.name == "nt"
HEADERS = Path(__file__).parent / "headers"
ZIG = "ziglang>=0.13"
QUICK = ["-fno-wrapv", "-fno-trapping-math", "-fno-math-errno"]  # what does not change results
FLAGS = ["-std=c11", "-O3", *QUICK, "-ffp-contract=off", "-fvisibility=hidden", "-g0"]  # doubles as written
VISUAL_STUDIO = ["/std:c11", "/O2", "/fp:strict"]  # the same for Microsoft's compiler
DEBUG = ["-Wall", "-Wextra", "-Werror", "-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=undefined"]


def requirements() -> list[str]:
    """What a build needs from the package index beside setuptools: nothing where there is a C compiler."""
    return [] if has_compiler() else [ZIG]


def has_compiler() -> bool:
    """Whether the system's C compiler compiles."""
    return _has_visual_studio() if WINDOWS else _compiles()


def include_folders() -> list[str]:
    """Our short Python.h, where this Python comes without its headers."""
    return [] if Path(sysconfig.get_path("include"), "Python.h").exists() else [str(HEADERS)]


def compile_with_zig(sources: Sequence[str], include: Sequence[str], macros: Mapping[str, str], target: Path) -> None:
    """Compile and link an extension module in one call of zig, for any processor of this kind."""
    if find_spec("ziglang") is None:
        raise SystemExit(f"no C compiler found: install one, or run `pip install '{ZIG}'`")
    target.parent.mkdir(parents=True, exist_ok=True)
    zig = [sys.executable, "-m", "ziglang", "cc", *FLAGS, "-mcpu=baseline", "-fPIC", "-shared", "-s"]
    given = [f"-D{name}={value}" for name, value in macros.items()]
    given += [f"-I{folder}" for folder in (*include, HEADERS)]
    subprocess.run([*zig, *given, *sources, *_linked(), "-o", str(target)], check=True)


def _linked() -> list[str]:
    """Python's own functions: found at import, or on Windows in python3.dll."""
    if WINDOWS:
        return [f"-L{Path(sys.base_prefix) / 'libs'}", "-lpython3"]
    return ["-undefined", "dynamic_lookup"] if sys.platform == "darwin" else ["-lm"]


def _compiles() -> bool:
    command = shlex.split(os.environ.get("CC") or sysconfig.get_config_var("CC") or "cc")
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "empty.c").write_text("#include <math.h>\nint empty;\n", "utf-8")
        try:  # where macOS lacks its developer tools, there is a `cc` that fails
            done = subprocess.run([*command, "-c", "empty.c"], cwd=folder, capture_output=True, check=False)
        except OSError:
            return False
    return done.returncode == 0


def _has_visual_studio() -> bool:
    from setuptools._distutils.ccompiler import new_compiler
    from setuptools.errors import PlatformError

    try:
        new_compiler(compiler="msvc").initialize()
    except PlatformError:
        return False
    return True
