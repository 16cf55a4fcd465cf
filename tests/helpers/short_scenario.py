"""The shortest drive that is one: six metres of straight road, 66 frames."""

from pathlib import Path

SHORT = """
schema = 1
[road]
segments = [{kind = "line", length_m = 80}]
[goal]
s_m = 11.0
[vary]
"ego.lateral_m" = [-0.3, 0.3]
"""


def write_short(folder: Path, goal_m: float = 11.0) -> Path:
    """The scenario file, in a folder, with a nearer goal where one is enough."""
    path = folder / "short.toml"
    path.write_text(SHORT.replace("s_m = 11.0", f"s_m = {goal_m}"))
    return path
