"""`python -m building`: build the camera's core in place, with the sources where it is imported from."""

import subprocess
import sys
from importlib.util import find_spec

from building.compiler import requirements
from building.extension import ROOT

missing = requirements()
if missing and find_spec("ziglang") is None:
    subprocess.run([sys.executable, "-m", "pip", "install", "--quiet", *missing], check=True)
build = [sys.executable, "setup.py", "--quiet", "build_ext", "--inplace", "--force"]
raise SystemExit(subprocess.run(build, cwd=ROOT, check=False).returncode)
