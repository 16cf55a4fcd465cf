"""Wrong files of each format: one line that begins with the file and names key, expected and actual; exit code 2.

Each check of a format has a case; the wording of a kind of fault is tested once, in tests/test_configuration.py.
"""

from pathlib import Path

import pytest
from gated_runs import run
from malformed import PLAIN as SCENARIO

from vpf_sim import cli

PLACE = "goal.s_m: expected a place ahead of the ego and on the road, after 5 and up to 170 m, got"
CHANGES = [
    ("lane_width_m", "lane_widht_m", "road.lane_widht_m: unknown key, did you mean 'lane_width_m'?"),
    ("[goal]", "[gaol]\ns_m = 1.0\n[goal]", "gaol: unknown key, did you mean 'goal'?"),
    ("[goal]", "[goal", "expected TOML, got: "),
    ("schema = 1", "schema = 2", "schema: expected 1, got 2"),
    ("lane_width_m = 3.5", "lane_width_m = -3.5", "road.lane_width_m: expected > 0, got -3.5"),
    ("length_m = 80", 'length_m = "80"', "road.segments[2].length_m: expected a number, got '80'"),
    ("length_m = 80, ", "", "road.segments[2].length_m: expected a value, got none"),
    ("length_m = 80", "length_m = 1e9", "road.segments: expected at most 20000 m in all, got 1e+09"),
    ('"arc"', '"ark"', "road.segments[2].kind: expected one of line, arc, clothoid, got 'ark': did you mean 'arc'?"),
    ("= -100}", "= -7}", "road.segments[1].end_radius_m: expected more than half the carriageway, 7 m, to either side"),
    ("lanes = 4", "lanes = 1000000000", "road.lanes: expected <= 20, got 1000000000"),
    ("lanes = 4", "lanes = 4\nstart_m = [1e300, 0.0]", "road.start_m[0]: expected <= 80000, got 1e+300"),
    ("lanes_m = [3.5, 3.5, ", "lanes_m = [", "road.widths[0].lanes_m: expected 4 widths, one for each lane, got 2"),
    ("lanes_m = [3.5, ", "lanes_m = [-3.5, ", "road.widths[0].lanes_m[0]: expected > 0, got -3.5"),
    ("s_m = 100.0", "s_m = 40.0", "road.widths[1].s_m: expected more than 40, as before, got 40"),
    ("s_m = 165.0", "s_m = 4.0", f"{PLACE} 4"),
    ("s_m = 165.0", "s_m = 171.0", f"{PLACE} 171"),
    ("s_m = 165.0", "s_n = 165.0", "goal.s_n: unknown key, did you mean 's_m'?"),
    ("lane = 2", "lane = 5", "bodies[0].lane: expected 1 to 4, counted from the right, got 5"),
    ("lane = 2", "lane = 1\nlateral_m = 0.5", "bodies[0].lateral_m: obstacle off the road: expected the whole object"),
    ("s_m = 90.0", "s_m = 168.0", "bodies[0].s_m: obstacle off the road: expected the whole object between 0 and 170"),
    ('"car"', '"cone"\nspeed_mps = 1.0', "bodies[0].speed_mps: expected 0 for a cone, which cannot move, got 1"),
    ("[vary]", "[ego]\nspeed_mps = 61.0\n[vary]", "ego.speed_mps: expected <= 60, got 61.0"),
    ("[vary]", "[limits]\ntime_s = 1e300\n[vary]", "limits.time_s: expected <= 100000, got 1e+300"),
    ("[-0.2, 0.3]", "[0.3, -0.2]", 'vary."bodies.lateral_m": expected [low, high] with low <= high, got [0.3, -0.2]'),
    ("bodies.lateral_m", "bodies.latral_m", 'vary."bodies.latral_m": expected one of ego.s_m, '),
    ("bodies.lateral_m", "bodies.speed_mps", 'vary."bodies.speed_mps": expected speeds that stay at or above 0, got'),
    (
        '"bodies.lateral_m" = [-0.2, ',
        '"ego.speed_mps" = [0, 9',
        'vary."ego.speed_mps": expected speeds that stay at or',
    ),
    ('"bodies.lateral_m" = [-0.2, 0.3]', '"ego.heading_deg" = [0, 1e308]', 'vary."ego.heading_deg": expected degrees'),
]
MOVES = "bodies[0].manoeuvres"
MANOEUVRES = [
    ("{lateral_m = 1.0}", f"{MOVES}[0]: expected either after_s or within_m, got neither"),
    ("{after_s = 1.0, within_m = 2.0, speed_mps = 1.0}", f"{MOVES}[0]: expected either after_s or within_m, got both"),
    ("{after_s = 1.0}", f"{MOVES}[0]: expected speed_mps, lateral_m or both, got neither"),
    ("{after_s = 1.0, lateral_m = 30.0}", f"{MOVES}[0].lateral_m: expected a place within 13 m of the"),
]
RANDOM, STRAIGHT = "schema = 1\n[random]\n", 'base = "straight"\n'
FAULTS, SENSORS = f"{STRAIGHT}[ego.sensor_faults]\n", f"{STRAIGHT}[ego.sensors]\n"
HIGHWAY = 'schema = 1\n[highway_env]\nid = "highway-v0"\n'
KEY = "highway_env.config"
MERGE, ROUND, OVAL = "merge-generic-v0", "roundabout-generic-v0", "racetrack-oval-v0"
OF_IDS = [
    *((MERGE, "before_merge_length", 59), (MERGE, "after_merge_length", 89), (MERGE, "parallel_merge_length", 20.5)),
    *((ROUND, "roundabout_radius", 14), (ROUND, "roundabout_lanes", 0), ("roundabout-v1", "roundabout_radius", 20)),
    *((OVAL, "length", 0), (OVAL, "block_lane", '"middle"'), ("racetrack-v1", "length", 100)),
]
SCENARIOS = [
    *((SCENARIO.replace(old, new, 1), line) for old, new, line in CHANGES),
    *((SCENARIO.replace("lane = 2", f"lane = 2\nmanoeuvres = [{given}]"), line) for given, line in MANOEUVRES),
    (f"{RANDOM}radius_m = [5.0, 90.0]", "random.radius_m: expected more than half the carriageway, 7 m, got 5"),
    (f"{RANDOM}rows = [3, 1]", "random.rows: expected [low, high] with low <= high, got [3, 1]"),
    (f"{RANDOM}rows = [0, 1000000000]", "random.rows[1]: expected <= "),
    (f"{RANDOM}length_m = [1.0, 1e9]", "random.length_m[1]: expected <= "),
    (f"{RANDOM}free_gap_m = 15.0", "random.free_gap_m: expected at most the carriageway, 14 m, got 15"),
    (f"{RANDOM}[ego]\nlane = 5", "ego.lane: expected 1 to 4, counted from the right, got 5"),
    ('base = "strait"', "base: unknown scenario 'strait': did you mean 'straight'?"),
    ("base = 1", "base: expected the name of a scenario, got 1"),
    (f"{FAULTS}drop_share = 1.5", "ego.sensor_faults.drop_share: expected <= 1, got 1.5"),
    (f"{FAULTS}latency_ms = -1", "ego.sensor_faults.latency_ms: expected >= 0, got -1"),
    (f"{FAULTS}drop_shar = 0.1", "ego.sensor_faults.drop_shar: unknown key, did you mean 'drop_share'?"),
    (f"{SENSORS}yaw_rate = 3.0", "ego.sensors.yaw_rate: unknown key, did you mean"),
    (f"{SENSORS}pitch_deg = -3.0", "ego.sensors.pitch_deg: expected"),
    (HIGHWAY.replace("v0", "v9"), "highway_env.id: expected one of highway-v0, "),
    (f"{HIGHWAY}config = {{lanes = 3}}", f"{KEY}.lanes: unknown key, did you mean 'lanes_count'?"),
    (f"{HIGHWAY}config = {{vehicles_count = 2.5}}", f"{KEY}.vehicles_count: expected an integer, got 2.5"),
    (f"{HIGHWAY}config = {{vehicles_count = -1}}", f"{KEY}.vehicles_count: expected "),
    (f"{HIGHWAY}config = {{initial_lane_id = 4}}", f"{KEY}.initial_lane_id: expected 0 to 3, "),
    (f"{HIGHWAY}config = {{destination = 'o1'}}", f"{KEY}.destination: expected a key of highway-v0"),
    (f"{HIGHWAY}config = 3", f"{KEY}: expected a table, got 3"),
    (f"{HIGHWAY}traffic = 1", "highway_env.traffic: expected true or false, got 1"),
    (f"{HIGHWAY}[road]\nlanes = 3", "road: unknown key"),
    (f"{HIGHWAY}[goal]\nroute_m = 0", "goal.route_m: expected > 0, got 0"),
    ("schema = 1\nhighway_env = 3", "highway_env: expected a table, got 3"),
    *((f"{HIGHWAY.replace('highway-v0', name)}config = {{{key} = {value}}}", f"{KEY}.{key}: expected ")
      for name, key, value in OF_IDS),
]  # fmt: skip
WEATHERS = [
    ("sun_altitude = 20.0", "sun_altitude: unknown key, did you mean 'sun_altitude_angle'"),
    ("sun_altitude_angle = 200.0", "sun_altitude_angle: expected <= 90, got 200.0"),
    ("sun_altitude_angle = 'noon'", "sun_altitude_angle: expected a number, got 'noon'"),
    ("base = 3", "base: expected the name of a weather, got 3"),
    ("base = 'ClaerNoon'", "base: unknown weather 'ClaerNoon': did you mean 'ClearNoon'"),
    ("base = 'other.toml'", "base: unknown weather 'other.toml': known: ClearDusk"),
    ("base = ", "expected TOML, got: Invalid value"),
    ("name = '\xe4'", "expected a readable weather file, got: not a text file"),
]
SWEEPS = [
    ('scenaro = ["town04"]', "scenaro: unknown key, did you mean 'scenario'?"),
    ('scenario = "town04"', "scenario: expected a list, got 'town04'"),
    ("scenario = [4]", "scenario[0]: expected a string, got 4"),
    ('seeds = "9:9"', "seeds: expected A:B with A below B, got '9:9', which holds no seed"),
    ("driver = []", "driver: expected at least one, got none"),
    ("weather = [", "expected TOML"),
]
RULES = [
    ("", "rules: expected a value, got none"),
    ("[[rules]]", "rules[0]: expected a bound, such as success_rate_at_least, or no_worse_than, got none"),
    ("[[rules]]\nsucess_rate_at_least = 1", "rules[0].sucess_rate_at_least: unknown key, did you mean 'success"),
    ("[[rules]]\nsuccess_rate_at_least = 95", "rules[0].success_rate_at_least: expected <= 1, got 95"),
    ("[[rules]]\ncollisions_at_most = 0.5", "rules[0].collisions_at_most: expected an integer, got 0.5"),
    ("[[rules]]\nclearance_m_at_least = -1", "rules[0].clearance_m_at_least: expected >= 0, got -1"),
    ('[[rules]]\ncollisions_at_most = 0\nscores = ["collisions"]', "rules[0].scores: expected no_worse_than"),
    ("[[rules]]\nperception.recal_at_least = 1", "rules[0].perception.recal_at_least: unknown key, did you mean 'reca"),
    ("[[rules]]\nperception.recall_at_least = 95", "rules[0].perception.recall_at_least: expected <= 1, got 95"),
    ("[[rules]]\nperception = 1", "rules[0].perception: expected a table, got 1"),
    ("[[rules]]\n[rules.perception]", "rules[0].perception: expected a bound, such as recall_at_least, got none"),
]
SETTINGS = [
    ('base = "robus"', "base: unknown variant 'robus': did you mean 'robust'?"),
    ("base = 3", "base: expected the name of a variant, got 3"),
    ("[flwo]\nx = 1", "flwo: unknown key, did you mean 'flow'?"),
    ("[flow]\nwindow = 3", "flow.window: unknown key, did you mean 'window_s'?"),
    ('road_edges = "robus"', "road_edges: unknown variant 'robus': did you mean 'robust'?"),
    ('odometry = "paper"', "odometry: expected a variant with [odometry], got 'paper'"),
    ('flow = "other.toml"', "flow: expected the name of a variant, got 'other.toml'"),
    ("flow = 3", "flow: expected a table, got 3"),
    ('gains = "motio"', "gains: unknown gains 'motio': did you mean 'motion'?"),
    ('static_obstacles = "none"', "[scene] needs [static_obstacles]"),
    ("[verges]\nbeside_m = 12.0", "verges.beside_m: expected at most 10.575, 0.9 of half the patch's width, got 12"),
    (
        "[road_edges]\nnarrowest_lane_m = 5.0",
        "road_edges.narrowest_lane_m: expected at most widest_lane_m, 4.25, got 5",
    ),
    ("[verges]\nsurface_m = 4.0", "verges.surface_m: expected at most 2.35, 0.2 of half the patch's width, got 4"),
]
DRIVES = [
    ("rate_hz = 1e9", "rate_hz: expected 0.2 to 1000, got 1e+09"),
    ("speed_mps = nan", "speed_mps: expected a number up to 1e+15, got nan"),
    ("[vehicle]\nwheelbase_m = 2700", "vehicle.wheelbase_m: expected 0.5 to 20, got 2700: another unit?"),
    ("[vehicle]\nsteering_ratio = 0.01", "vehicle.steering_ratio: expected 1 to 100, got 0.01"),
    ("[camera]\nheight_m = 140", "camera.height_m: expected 0.1 to 10, got 140: another unit?"),
    ("[camera]\nfx_px = 4.2", "camera.fx_px: expected 10 to 100000, got 4.2: millimetres?"),
    ("[camera]\ndistortion = [nan, 0.0]", "camera.distortion[0]: expected a number up to 1e+15, got nan"),
]
FORMATS = {"scenario": SCENARIOS, "weather": WEATHERS, "sweep": SWEEPS, "rules": RULES, "settings": SETTINGS}
COMMANDS = {
    "scenario": ["scenarios", "validate", "PATH"],
    "weather": ["weathers", "validate", "PATH"],
    "sweep": ["sweep", "PATH"],
    "rules": ["check", "RUN", "--rules", "PATH"],
    "settings": ["drive", "straight", "--driver", "vpf@PATH"],
    "drive": ["replay", "FOLDER", "--driver", "neutral"],
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return run(tmp_path_factory.mktemp("rules") / "run", lambda _: {})


def refused(kind: str, text: str, folder: Path, path: Path, capsys: pytest.CaptureFixture[str]) -> list[str]:
    """The lines of the command that reads a file of the kind."""
    path.write_text(text, "latin-1")
    places = {"PATH": str(path), "RUN": str(folder), "FOLDER": str(path.parent)}
    command = COMMANDS[kind]
    for word, place in places.items():
        command = [given.replace(word, place) for given in command]
    assert cli.run(command) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert list(path.parent.iterdir()) == [path], "nothing is left behind"
    return said.err.splitlines()


@pytest.mark.parametrize(
    ("kind", "text", "line"),
    [
        *((kind, *case) for kind, cases in FORMATS.items() for case in cases),
        *(("drive", f"schema = 1\n{text}\n", line) for text, line in DRIVES),
    ],
)
def test_a_fault_is_one_line_with_file_and_key(
    kind: str, text: str, line: str, folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "drive.toml"
    (said,) = refused(kind, text, folder, path, capsys)
    assert said.startswith(f"vpf-sim: {path}: {line}")


TWO_FAULTS = [
    ("scenario", SCENARIO.replace("s_m = 165.0", "place = 165.0"), ["goal.place", "goal.s_m"]),
    ("scenario", SCENARIO.replace("165.0", "4.0").replace("lane = 2", "lane = 5"), ["bodies[0].lane", "goal.s_m"]),
    ("weather", "droplets = -1.0\nfog = 3.0", ["droplets", "fog"]),
    ("rules", '[[rules]]\ndriver = 3\n[[rules]]\nscores = ["x"]', ["rules[0].driver", "rules[1].scores[0]"]),
]


@pytest.mark.parametrize(("kind", "text", "keys"), TWO_FAULTS)
def test_each_fault_of_a_file_has_a_line(
    kind: str, text: str, keys: list[str], folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lines = refused(kind, text, folder, tmp_path / "mine.toml", capsys)
    assert sorted(line.split(": ")[2] for line in lines) == keys


@pytest.mark.parametrize("kind", ["scenario", "weather", "sweep", "rules"])
def test_a_missing_file_is_named(kind: str, folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    places = {"PATH": str(tmp_path / "gone.toml"), "RUN": str(folder)}
    assert cli.run([places.get(word, word) for word in COMMANDS[kind]]) == 2
    assert f"{tmp_path / 'gone.toml'}: expected a readable" in capsys.readouterr().err


NO_TOML = [
    b"<?xml?>\n",
    b"\x1f\x8b\x08\x00" * 40,
    b"base = \xff\xfe",
    b"more = " + b"[" * 20_000,
    b"x = " + b"9" * 5000,
]


@pytest.mark.parametrize("kind", FORMATS)
@pytest.mark.parametrize("content", NO_TOML, ids=["xml", "archive", "utf-16", "deep", "long"])
def test_a_file_that_is_something_else_is_one_line(
    kind: str, content: bytes, folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (said,) = refused(kind, content.decode("latin-1"), folder, tmp_path / "mine.toml", capsys)
    assert said.startswith(f"vpf-sim: {tmp_path / 'mine.toml'}: ")
    assert len(said) < 1000


def test_the_changed_files_are_valid_before_the_change(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(SCENARIO)
    assert cli.run(["scenarios", "validate", str(tmp_path / "mine.toml")]) == 0
