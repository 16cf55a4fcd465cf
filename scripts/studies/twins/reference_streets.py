"""Streets that match the recorded drives, by the drive's name."""

from math import atan2

from street import Street, street_object

from vpf_sim.types import Camera

HIGHWAY_MPS = 25.3  # a stripe and a gap, 12.19 m, in 12.05 frames of 1/25 s

STREETS = {
    # A queue before a traffic light: a lead car, a tanker on the right, a lorry on the left, the sun on the right.
    # The noise is that of its flattest bright surfaces.
    "kitti_raw_leadcar": Street(
        lanes=4,
        lane=2,
        lateral_m=-0.3,
        heading_deg=145.0,
        weather="ClearNoon",
        look={"stripe_m": 6.0, "gap_m": 3.0, "grain": 2.0},
        noise_sd=2.5,
        exposure_ev=0.7,
        lead=0,
        objects=(
            street_object("car", 12.5, 2, speed_mps=1.0),
            street_object("van", 6.4, 1, speed_mps=2.05),  # the tanker's tractor, and its tank
            street_object("truck", -1.5, 1, speed_mps=2.05),
            street_object("van", 14.5, 3),
            street_object("car", 5.6, 3, -0.2),
            street_object("car", 26.0, 2),
            street_object("car", 24.0, 1),
            street_object("van", 35.0, 2),
            street_object("car", 32.0, 3),
        ),
    ),
    # A motorway of California: the camera in the right lane, faster traffic on the left, dry grass beside it.
    "carnd_highway": Street(
        lanes=4,
        lane=1,
        lateral_m=-0.1,
        weather="ClearNoon",
        lane_width_m=3.66,
        look={"verge": "sand", "surface": "dark", "grain": 0.35, "stripe_m": 3.05, "gap_m": 9.14, "studs": True},
        pitch_deg=0.08,
        blur_px=1.0,
        noise_sd=0.5,
        # From the vanishing point, and from the distance between the lines and between the stripes.
        camera=Camera(
            960, 540, 925.0, 925.0, 479.5, 269.5, height_m=1.24, forward_m=0.0, pitch_rad=-atan2(34.5, 925.0)
        ),
        speed_mps=HIGHWAY_MPS,
        objects=(
            street_object("van", 21.0, 4, speed_mps=HIGHWAY_MPS + 4.0),
            street_object("car", 6.9, 3, 0.3, speed_mps=HIGHWAY_MPS + 2.7),
            street_object("car", 5.7, 4, 0.5, speed_mps=HIGHWAY_MPS + 3.0),
            street_object("car", 62.5, 2, speed_mps=HIGHWAY_MPS + 1.6),
            street_object("car", 67.5, 3, speed_mps=HIGHWAY_MPS + 2.0),
            street_object("van", 62.5, 4, speed_mps=HIGHWAY_MPS + 2.0),
            street_object("car", 115.0, 1, speed_mps=HIGHWAY_MPS),
            street_object("truck", 160.0, 2, speed_mps=HIGHWAY_MPS),
        ),
    ),
}
