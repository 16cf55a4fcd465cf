"""One thread in OpenCV, as on the command line: tests that run side by side do not wait for each other's threads."""

from vpf_sim.system import limit_opencv

limit_opencv()
