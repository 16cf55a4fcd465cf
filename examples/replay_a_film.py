"""Film a drive in the simulator, and replay the film as if it came from a dash cam.

`vpf-sim replay` gets the film and the camera's field of view alone. It derives speed and steering of the car that
was filmed, and compares the latter with what `vpf` would have done. Prints

    181 frames, lane found in 100%
    speed 5.5 m/s, derived 5.5 m/s
    steering differs from the film's by 0.2 deg on average

python replay_a_film.py [FOLDER] keeps film and report in FOLDER. Needs `pip install 'vpf_sim[video]'`.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import av
import duckdb

import vpf_sim
from vpf_sim.drivers import RouteDriver


class Filming(RouteDriver):
    """The PID with a camera: every third frame goes into the film, which is 20 a second."""

    uses_images = True

    def __init__(self, film: av.container.OutputContainer) -> None:
        super().__init__("pid")
        self.film, self.stream, self.frames = film, film.add_stream("libx264", rate=20), 0

    def act(self, observation: vpf_sim.Observation) -> vpf_sim.Command:
        if self.frames % 3 == 0:
            self.film.mux(self.stream.encode(av.VideoFrame.from_ndarray(observation.image)))
        self.frames += 1
        return super().act(observation)


def main(folder: Path) -> None:
    folder.mkdir(exist_ok=True)
    (folder / "road.toml").write_text('base = "curve-left"\ngoal = {s_m = 55.0}\n')
    (folder / "drive.toml").write_text("schema = 1\ncamera = {field_of_view_deg = 90.0}\n")
    with av.open(folder / "drive.mp4", "w") as film:
        vpf_sim.drive(folder / "road.toml", driver=(driver := Filming(film)))
        film.mux(driver.stream.encode())
    replay = [sys.executable, "-m", "vpf_sim.cli", "replay", ".", "--no-video", "--json", "--out", "replay"]
    found = json.loads(subprocess.run(replay, cwd=folder, check=True, capture_output=True).stdout)["drives"][0]
    speeds_mps = duckdb.read_parquet(f"{folder}/replay/frames/*.parquet").df()["speed_mps"]
    print(f"{found['frames']} frames, lane found in {found['perception']['road_found_share']:.0%}")
    print(f"speed 5.5 m/s, derived {speeds_mps.median():.1f} m/s")
    print(f"steering differs from the film's by {40.0 * found['accuracy']['steering']['mae']:.1f} deg on average")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as temporary:
        main(Path(sys.argv[1] if sys.argv[1:] else temporary))
