"""The camera's core as an extension module of Python's stable ABI."""

import os
import runpy
from pathlib import Path

from setuptools import Extension
from setuptools.command.build_ext import build_ext

from building import compiler

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "envs" / "camera" / "core"
DIGEST = runpy.run_path(str(FOLDER / "sources.py"))["digest"](FOLDER)


def core() -> Extension:
    """The extension from all C files in its folder and below; paths are relative, as setuptools wants them."""
    files = sorted(path.relative_to(ROOT).as_posix() for path in FOLDER.rglob("*.[ch]"))
    return Extension(
        "vpf_sim.envs.camera.core._core",
        sources=[name for name in files if name.endswith(".c")],
        depends=[name for name in files if name.endswith(".h")],
        define_macros=[("Py_LIMITED_API", "0x030B0000"), ("VC_SOURCES", DIGEST)],
        include_dirs=[FOLDER.relative_to(ROOT).as_posix(), *compiler.include_folders()],
        libraries=["python3"] if compiler.WINDOWS else ["m"],
        py_limited_api=True,
    )


class BuildCore(build_ext):
    """Build with exact arithmetic, by the system's compiler or by zig; VPF_SIM_CORE=debug adds checks."""

    def build_extension(self, ext: Extension) -> None:
        """Compile one extension."""
        if not compiler.has_compiler():
            target = Path(self.get_ext_fullpath(ext.name))
            compiler.compile_with_zig(ext.sources, ext.include_dirs[:1], dict(ext.define_macros), target)
            return
        ext.extra_compile_args = [*(compiler.VISUAL_STUDIO if compiler.WINDOWS else compiler.FLAGS)]
        if os.environ.get("VPF_SIM_CORE") == "debug":
            ext.define_macros.append(("VC_DEBUG", "1"))
            ext.extra_compile_args += compiler.DEBUG
            ext.extra_link_args = compiler.DEBUG
        super().build_extension(ext)
