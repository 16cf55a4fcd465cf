"""The page that compares a run with the paper: its table, definitions, claims and figures."""

import json
from base64 import b64encode
from pathlib import Path
from typing import Any

import numpy as np

from vpf_sim.evaluation.analysis import reproduction
from vpf_sim.evaluation.analysis.benchmark import SCENARIOS
from vpf_sim.evaluation.analysis.paper_claims import claims
from vpf_sim.evaluation.analysis.reproduction import CELLS, REFERENCE_DRIVER, Drive
from vpf_sim.evaluation.job import Job
from vpf_sim.files import write_bytes, write_text
from vpf_sim.reporting import paper_figures
from vpf_sim.reporting.redraw import Redrawing
from vpf_sim.reporting.road_layout import layouts
from vpf_sim.reporting.stored_run import StoredRun
from vpf_sim.reporting.templates import render

JSON, PAGE = "paper.json", "paper.html"
NO_OBSTACLE_M = 40.0  # along the route, where to take the picture on a road without obstacles


def drives_of(run: StoredRun, driver: str) -> list[Drive]:
    """The episodes of a driver, each with the PID's on the same seed without obstacles: the planned trajectory."""
    found = []
    for record in run.records.values():
        table = run.steps(record.id)
        if record.driver == driver and table is not None:
            pid = run.steps(Job(SCENARIOS[0], record.weather, REFERENCE_DRIVER, record.seed).id)
            found.append(Drive(record.scenario, record.weather, record, table, pid))
    return found


def answer(run: StoredRun, driver: str, drives: list[Drive]) -> dict[str, Any]:
    """The content of paper.json."""
    rows = reproduction.cells(drives)
    timing = [run.timing[drive.record.id] for drive in drives if drive.record.id in run.timing]
    times = [time.stages_ms["driver"] for time in timing if "driver" in time.stages_ms]
    return {
        "driver": driver,
        "cells": rows,
        "definitions": reproduction.definitions(rows),
        "claims": claims(rows, drives, float(np.median(times)) if times else None),
    }


def write(folder: Path, drives: list[Drive], found: dict[str, Any]) -> Path:
    """Write paper.json, the figures as PNG files, and the page with all of it; the page's path."""
    figures = _figures(drives)
    for name, picture in figures.items():
        write_bytes(folder / f"{name}.png", picture)
    write_text(folder / JSON, json.dumps(found, indent=2, allow_nan=False))
    pictures = {name: b64encode(picture).decode() for name, picture in figures.items()}
    page = render("paper.html.jinja", **found, pictures=pictures, signals=reproduction.SIGNALS)
    write_text(folder / PAGE, page)
    return folder / PAGE


def _figures(drives: list[Drive]) -> dict[str, bytes]:
    seeds = {scenario: sorted({one.record.seed for one in drives if one.scenario == scenario}) for scenario, _ in CELLS}
    where = {
        (scenario, seed): layout for scenario, some in seeds.items() for seed, layout in layouts(scenario, some).items()
    }
    found = {}
    for cell in CELLS:
        here = [drive for drive in drives if (drive.scenario, drive.weather) == cell]
        shown = min(here, key=lambda drive: (not drive.succeeded, drive.record.seed), default=None)
        if shown is not None:
            obstacles = where[cell[0], shown.record.seed].static_obstacles
            face_m = min((obstacle.route_m[0] for obstacle in obstacles), default=NO_OBSTACLE_M)
            drawing = Redrawing(shown.record, shown.table, replan=True)
            found[cell] = paper_figures.forces_along(drawing, face_m)
    return {
        "paths": paper_figures.paths(drives, where),
        "flow": paper_figures.flow(found),
        "forces": paper_figures.forces(found),
    }
