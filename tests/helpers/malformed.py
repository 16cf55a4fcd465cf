"""Valid inputs made malformed by seeded mutation: a wrong key, a wrong type, broken syntax, bytes that are no text."""

import json
import re
from collections.abc import Callable
from pathlib import Path
from random import Random

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
MANIFEST = {
    "schema": 1,
    "command": "sweep",
    "plan": {"scenario": ["straight"], "weather": ["clear"], "driver": ["vpf"], "seeds": "0:3"},
    "fingerprint": {},
    "scenarios": {"straight": "abc"},
    "weathers": {"clear": "def"},
}
Mutation = Callable[[str, Random], bytes]


def _some(text: str, pattern: str, chance: Random, change: Callable[[re.Match[str]], str]) -> bytes:
    """The text with one of the places that match changed."""
    found = chance.choice(list(re.finditer(pattern, text, re.MULTILINE)))
    return (text[: found.start()] + change(found) + text[found.end() :]).encode()


def misspell(text: str, chance: Random) -> bytes:
    """A letter twice in a key."""
    return _some(text, r"^(\w)(\w+) =", chance, lambda m: f"{m[1]}{m[2][0]}{m[2]} =")


def wrong_type(text: str, chance: Random) -> bytes:
    other = chance.choice(["{a = 1}", "1979-05-27", "true", "[[[]]]"])
    return _some(text, r"^(\w+) = .*$", chance, lambda m: f"{m[1]} = {other}")


def no_number(text: str, chance: Random) -> bytes:
    if not re.search(r"= -?[\d.]+$", text, re.MULTILINE):
        return wrong_type(text, chance)
    wrong = chance.choice(["nan", "inf", "-inf", "-1e300", '"4"', "1e999", "9" * 5000])
    return _some(text, r"= -?[\d.]+$", chance, lambda _: f"= {wrong}")


def unclosed(text: str, chance: Random) -> bytes:
    """A bracket or a quotation mark is lost."""
    return _some(text, r'[\]"]', chance, lambda _: "")


def twice(text: str, chance: Random) -> bytes:
    """A key stands twice."""
    return _some(text, r"^\w+ = .*$", chance, lambda m: f"{m[0]}\n{m[0]}")


def no_text(text: str, chance: Random) -> bytes:
    place = chance.randrange(len(text))
    return text[:place].encode() + chance.choice([b"\xff\xfe", b"\x00", b"\x89PNG\r\n\x1a\n"]) + text[place:].encode()


def foreign(_: str, chance: Random) -> bytes:
    """A file that is something else."""
    return chance.choice([b"\\documentclass{article}\n", b'{"a": [1, 2]}\n', b"<?xml?>\n", b"\x1f\x8b\x08\x00" * 40])


def deep(text: str, chance: Random) -> bytes:
    """Nested far beyond what any reader follows."""
    return (text + f"\nmore{chance.randrange(9)} = " + "[" * 20_000).encode()


MUTATIONS: tuple[Mutation, ...] = (misspell, wrong_type, no_number, unclosed, twice, no_text, foreign, deep)


def spoil_folder(path: Path, chance: Random) -> None:
    """A run folder, torn or foreign."""
    text, kind = json.dumps(MANIFEST), chance.randrange(7)
    path.mkdir()
    (path / "episodes.jsonl").write_text("")
    manifest = path / "manifest.json"
    if kind == 0:
        manifest.write_text(text[: chance.randrange(len(text) - 1)])
    elif kind == 1:
        (path / "thesis.tex").write_text("\\documentclass{article}")
        manifest.write_bytes(foreign("", chance))
    elif kind == 2:
        gone = chance.choice(["plan", "fingerprint", "scenarios", "weathers"])
        manifest.write_text(json.dumps({key: value for key, value in MANIFEST.items() if key != gone}))
    elif kind == 3:
        key = chance.choice(["scenario", "weather", "driver", "seeds"])
        plan = {**MANIFEST["plan"], key: chance.choice([7, None, "x", {}, [[]]])}  # type: ignore[dict-item]
        manifest.write_text(json.dumps({**MANIFEST, "plan": plan}))
    elif kind == 4:
        manifest.write_text("[" * 100_000)
    elif kind == 5:
        manifest.mkdir()
    else:
        manifest.write_text(text)
        line = chance.choice(
            [b'{"id": "a"', b"[1]", b"\xff\xff", b'{"seed": 1}', b"[" * 100_000, b'{"id": 5, "a": NaN}']
        )
        (path / "episodes.jsonl").write_bytes(line + b"\n" + b'{"id": "b"}\n')
