"""Size and time of drivers: lines of code, settings, weights of a network, and milliseconds a step.

    python scripts/complexity.py [RUN ...] [--drivers vpf lane-lines pid]

Each driver drives two seconds of `town04` in a process of its own. Lines are those of the functions of perception,
planning, control and drivers that run, without blank lines, comments and docstrings. Settings are the numbers in their
configuration and in the constants of their modules. Times are medians over the episodes of the runs, which must have
been driven on an idle machine.
"""

import argparse
import ast
import gc
import json
import subprocess
import sys
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

PARTS = tuple(f"vpf_sim.{part}" for part in ("perception", "scene", "planning", "controllers", "drivers", "braking"))
DRIVERS = ("vpf", "vpf-paper", "lane-lines", "pid", "stanley", "idm")
STEPS = 120
ONE = "--one"  # measure one driver and print JSON


@dataclass(frozen=True, slots=True)
class Size:
    """What a driver is made of."""

    files: int
    lines: int  # of code
    settings: int
    weights: int  # 0 without a network


def size_of(driver: str) -> Size:
    """The size of a driver, which drives in a process of its own."""
    done = subprocess.run([sys.executable, __file__, ONE, driver], check=True, capture_output=True, text=True)
    found: dict[str, Any] = json.loads(done.stdout)
    functions = {Path(path): lines for path, lines in found["functions"].items()}
    lines = sum(code_lines(path, first) for path, first in functions.items())
    settings = found["settings"] + sum(constants(path) for path in functions)
    return Size(len(functions), lines, settings, found["weights"])


def measure(name: str) -> dict[str, Any]:
    """Drive, and list the first lines of the functions that run, by file, and the settings that are alive."""
    from vpf_sim import drivers, process_state
    from vpf_sim.envs.four_lane import FourLane
    from vpf_sim.evaluation.episode.episode import read, setup_for

    env, driver = FourLane("town04"), drivers.create(name)
    observed, _ = env.reset(seed=3)
    ran: dict[str, set[int]] = {}

    def note(frame: Any, event: str, _: Any) -> None:
        if event == "call":
            ran.setdefault(frame.f_code.co_filename, set()).add(frame.f_code.co_firstlineno)

    sys.setprofile(note)
    driver.reset(setup_for(driver, env, 3))
    for _ in range(STEPS):
        command = drivers.command_of(driver, read(observed))
        observed, *_ = env.step(np.array([command.throttle, command.steering]))
    sys.setprofile(None)
    parts = (*PARTS, f"{type(process_state.unwrapped(driver)).__module__.partition('.')[0]}.")  # those of its package
    parts = PARTS if parts[-1] == "vpf_sim." else parts
    ours = {str(module.__file__) for key, module in sys.modules.items() if f"{key}.".startswith(parts)}
    settings = sum(numbers(item) for item in gc.get_objects() if is_configuration(item))
    model = getattr(driver, "model_path", None)
    functions = {path: sorted(lines) for path, lines in ran.items() if path in ours}
    return {"functions": functions, "settings": settings, "weights": weights_of(model) if model else 0}


def weights_of(model: Path) -> int:
    """The numbers that a network has learned."""
    import onnx

    return sum(int(np.prod(tensor.dims)) for tensor in onnx.load(model).graph.initializer)


def is_configuration(item: object) -> bool:
    """Whether an object is filled from a TOML file of perception, planning, control or a driver."""
    kind = type(item)
    return is_dataclass(kind) and hasattr(kind, "__pydantic_config__") and kind.__module__.startswith(PARTS)


def numbers(config: Any) -> int:
    """The numbers in a section's own keys."""
    values = [getattr(config, item.name) for item in fields(config)]
    return sum(np.size(value) for value in values if isinstance(value, int | float | tuple) and value != ())


def code_lines(path: Path, first_lines: list[int]) -> int:
    """Lines with code of the functions that begin in these lines."""
    text, code = path.read_text("utf-8").splitlines(), set()
    for node in ast.walk(ast.parse("\n".join(text))):
        if isinstance(node, ast.FunctionDef | ast.Lambda) and _begins(node) in first_lines:
            documented = isinstance(node, ast.FunctionDef) and ast.get_docstring(node) is not None
            silent = range(node.body[0].lineno, node.body[0].end_lineno + 1) if documented else range(0)
            code |= set(range(node.lineno, (node.end_lineno or node.lineno) + 1)) - set(silent)
    stripped = (text[number - 1].strip() for number in code)
    return sum(bool(line) and not line.startswith("#") for line in stripped)


def _begins(node: ast.FunctionDef | ast.Lambda) -> int:
    """The first line of a function as its code object has it: that of its first decorator."""
    decorators = node.decorator_list if isinstance(node, ast.FunctionDef) else []
    return min([node.lineno, *(one.lineno for one in decorators)])


def constants(path: Path) -> int:
    """The numbers in constants of a module."""
    assigned = [
        node for node in ast.parse(path.read_text("utf-8")).body if isinstance(node, ast.Assign | ast.AnnAssign)
    ]
    return sum(
        isinstance(leaf, ast.Constant) and isinstance(leaf.value, int | float) and not isinstance(leaf.value, bool)
        for node in assigned
        for leaf in ast.walk(node)
    )


def times_ms(runs: list[Path]) -> dict[str, list[float]]:
    """The driver's milliseconds a step of each episode, by driver."""
    found: dict[str, list[float]] = {}
    for folder in runs:
        drivers = {row["id"]: row["driver"] for row in map(json.loads, (folder / "episodes.jsonl").open())}
        for row in map(json.loads, (folder / "timing.jsonl").open()):
            if row["id"] in drivers and "driver" in row.get("stages_ms", {}):
                found.setdefault(drivers[row["id"]], []).append(row["stages_ms"]["driver"])
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("runs", nargs="*", type=Path)
    parser.add_argument("--drivers", nargs="+", default=list(DRIVERS))
    requested = parser.parse_args()
    times = times_ms(requested.runs)
    print("| driver | files | lines of code | settings | weights | ms a step |")
    print("|---|---:|---:|---:|---:|---:|")
    for driver in requested.drivers:
        size = size_of(driver)
        weights = f"{size.weights:,}" if size.weights else "-"
        taken = f"{np.median(times[driver]):.2f}" if driver in times else "-"
        print(f"| {driver} | {size.files} | {size.lines:,} | {size.settings} | {weights} | {taken} |", flush=True)


if __name__ == "__main__":
    if sys.argv[1:2] == [ONE]:
        print(json.dumps(measure(sys.argv[2])))
    else:
        main()
