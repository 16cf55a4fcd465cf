"""What the bytes of an episode depend on beside its inputs: versions, and OpenCV's use of the CPU."""

import json
import platform
from hashlib import sha256

FINGERPRINT_KEYS = ("python", "numpy", "opencv", "opencv_cpu_features", "highway_env", "vpf_sim")


def fingerprint() -> dict[str, str]:
    """The values of FINGERPRINT_KEYS in this process."""
    from importlib.metadata import version

    import cv2
    import numpy as np

    import vpf_sim

    return {
        "python": platform.python_version(),
        "numpy": np.__version__,
        "opencv": cv2.__version__,
        "opencv_cpu_features": cv2.getCPUFeaturesLine(),
        "highway_env": version("highway-env"),
        "vpf_sim": vpf_sim.__version__,
    }


def digest(value: object) -> str:
    """A short name for a value that JSON can hold."""
    return sha256(json.dumps(value, sort_keys=True).encode()).hexdigest()[:16]
