"""The tables that `vpf-sim replay` prints."""

from collections.abc import Sequence
from typing import Any

from vpf_sim.cli.tables import number, percent, print_table

PART_NAMES = {"clear_of_obstacles": "no obstacles", "with_obstacles": "with obstacles", "not divided": "not divided"}
NOTHING = "no recording"


def print_all(records: Sequence[dict[str, Any]], timing: dict[str, Any], summary: dict[str, Any]) -> None:
    """Commands beside the human's and the paper's, what each row rests on, perception beside the truth, time."""
    print(
        "throttle and steering beside the human's, accuracy in %: range, span, tolerance; mae; idle: touching nothing\n"
    )
    _accuracy(summary["rows"])
    print()
    for words in summary["differences"]:
        print(f"- {words}")
    print("\nwhat each drive is\n")
    _drives(records)
    print("\nperception beside the truth, medians\n")
    _perception(records)
    print("\ntime on one core, ms a frame\n")
    _timing(timing)
    for record in records:
        for note in record["notes"]:
            print(f"{record['name']}: {note}")


def _accuracy(rows: Sequence[dict[str, Any]]) -> None:
    header = ("weather", "part", "throttle", "steering", "frames")
    scores = ("a range", "span", "tol.", "mae", "idle", "d range", "span", "tol.", "mae", "idle", "paper a", "paper d")
    print_table((*header, *scores), [_row(row) for row in rows], 4)


def _row(row: dict[str, Any]) -> list[str]:
    weather = row["weather"] + (f" + {row['added']}" if row["added"] else "")
    signals = [row["signals"][name] or "-" for name in ("throttle", "steering")] if row["frames"] else [NOTHING, ""]
    cells = [weather, PART_NAMES[row["part"]], *signals, str(row["frames"])]
    for name in ("throttle", "steering"):
        scores, idle = row["accuracy"][name] or {}, row["idle"][name] or {}
        cells += [percent(scores.get(key)) for key in ("range", "span", "tolerance")]
        cells += [number(scores.get("mae"), 3), percent(idle.get("range"))]
    paper = row["paper"] or {}
    return [*cells, *(percent(paper.get(name)) for name in ("throttle", "steering"))]


def _drives(records: Sequence[dict[str, Any]]) -> None:
    header = ("drive", "layout", "weather", "camera", "throttle", "steering", "obstacles", "road found %", "gaps")
    print_table(header, [_drive(record) for record in records], 7)
    for record in records:
        print(f"{record['name']}: goal: {record['goal']}; {record['protocol']}")
        for name in ("camera", "poses", "speed_mps", "yaw_rate_radps", "throttle", "steering_rad"):
            origin = record["origins"][name]
            how = f" ({origin['how']})" if origin["how"] else ""
            print(f"{record['name']}: {name}: {origin['kind']}{how}")


def _drive(record: dict[str, Any]) -> list[str]:
    camera = record["camera"]
    kinds = [record["origins"][name]["kind"] for name in ("throttle", "steering_rad")]
    return [
        record["name"],
        record["layout"],
        record["weather"] or "not told",
        f"{camera['width_px']} x {camera['height_px']}, {record['rate_hz']:.3g} Hz",
        *kinds,
        record["obstacles_by"] or "-",
        percent(record["perception"]["road_found_share"]),
        str(record["gaps"]),
    ]


def _perception(records: Sequence[dict[str, Any]]) -> None:
    header = ("drive", "frames", "FOE x px", "FOE y px", "own x px", "own y px", "FOE there %", "spread x px", "y px")
    more = ("yaw rate rad/s", "speed scale", "TTC error %", "in 25 %", "false alarms %")
    print_table((*header, *more), [_seen(record) for record in records])
    print(
        "\nFOE: focus of expansion, the recorded rotation removed; own: told of no rotation; spread: quartiles' range"
    )


def _seen(record: dict[str, Any]) -> list[str]:
    seen = record["perception"]
    errors = [record[key] or {} for key in ("foe_median_error_px", "foe_median_error_own_derotation_px")]
    spread, ttc = seen["foe"]["interquartile_range_px"] or {}, seen["ttc"] or {}
    return [
        record["name"],
        str(record["frames"]),
        *(number(error.get(axis), 1) for error in errors for axis in ("x", "y")),
        percent(seen["foe"]["share"]),
        *(number(spread.get(axis), 1) for axis in ("x", "y")),
        number(seen["yaw_rate_median_error_radps"], 4),
        number((seen["speed_scale"] or {}).get("median")),
        percent(ttc.get("median_error")),
        percent(ttc.get("within_25_percent")),
        percent(ttc.get("false_alarms")),
    ]


def _timing(timing: dict[str, Any]) -> None:
    header = ("drive", "driver", "95 %", "reading", "period", "times real time")
    keys = ("driver_ms", "driver_p95_ms", "reading_ms", "period_ms", "real_time")
    print_table(header, [[name, *(number(timing[name][key], 1) for key in keys)] for name in sorted(timing)])
