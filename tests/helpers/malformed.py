"""A valid file of each format, for tests that change it."""

PLAIN = """
schema = 1
[road]
lanes = 4
lane_width_m = 3.5
segments = [
  {kind = "line", length_m = 60},
  {kind = "clothoid", length_m = 30, end_radius_m = -100},
  {kind = "arc", length_m = 80, radius_m = -100},
]
[[road.widths]]
s_m = 40.0
lanes_m = [3.5, 3.5, 3.5, 3.5]
[[road.widths]]
s_m = 100.0
lanes_m = [3.5, 3.5, 3.5, 3.5]
[goal]
s_m = 165.0
[[bodies]]
kind = "car"
s_m = 90.0
lane = 2
[vary]
"bodies.lateral_m" = [-0.2, 0.3]
"""
SCENARIO = """schema = 1
[road]
lanes = 4
lane_width_m = 3.5
start_m = [0.0, 0.0]
heading_deg = 30.0
segments = [{kind = "line", length_m = 60}, {kind = "arc", length_m = 80, radius_m = -100}]
[[road.widths]]
s_m = 20.0
lanes_m = [3.5, 3.5, 3.5, 3.5]
[[road.widths]]
s_m = 60.0
lanes_m = [3.0, 3.5, 3.75, 3.5]
left_edge_m = -7.0
[ego]
lane = 2
s_m = 5.0
speed_mps = 5.55
[goal]
s_m = 120.0
kind = "reach"
[[bodies]]
kind = "car"
s_m = 90.0
lane = 2
[limits]
time_s = 120.0
[vary]
"ego.lateral_m" = [-0.3, 0.3]
"""
WEATHER = """base = "HardRainNoon"
cloudiness = 60.0
precipitation = 40.0
fog_density = 5.0
wiper_period_s = 1.3
"""
SWEEP = """scenario = ["straight", "town04"]
weather = ["clear", "rain"]
driver = ["pid", "neutral"]
seeds = "0:3"
"""
RULES = """[[rules]]
driver = "vpf"
success_rate_at_least = 0.9
path_mse_m2_upper_at_most = 0.5
[[rules]]
weather = "rain"
collisions_at_most = 0
"""
