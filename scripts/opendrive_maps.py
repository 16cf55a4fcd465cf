"""Which roads of OpenDRIVE maps load: a Markdown table of a folder of .xodr files, for docs/opendrive.md.

    python scripts/opendrive_maps.py FOLDER

Each road is tried in each direction in which it has driving lanes, as a route of its own. Files with the same content
count once.
"""

import hashlib
import re
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from vpf_sim.configuration import build
from vpf_sim.errors import InputError
from vpf_sim.scenarios.checks import road_faults
from vpf_sim.scenarios.opendrive.convert import route_table
from vpf_sim.scenarios.opendrive.network import Network
from vpf_sim.scenarios.opendrive.road_section import Direction, OpenDriveRoad
from vpf_sim.scenarios.opendrive.routes import Leg
from vpf_sim.scenarios.parts import Road

HEAD = "| map | directions | loaded | refused |\n|---|---|---|---|"


def main() -> None:
    if len(sys.argv) != 2:
        raise SystemExit(__doc__)
    folder, seen, totals, refused = Path(sys.argv[1]), set(), Counter[str](), Counter[str]()
    print(HEAD)
    for path in sorted(folder.rglob("*.xodr")):
        content = hashlib.sha256(path.read_bytes()).digest()
        if content in seen:
            continue
        seen.add(content)
        outcomes = Counter(outcome for outcome in _outcomes(path) if outcome != "no driving lane")
        tried, loaded = sum(outcomes.values()), outcomes.pop("loaded", 0)
        if tried == 0:
            continue
        totals.update({"maps": 1, "tried": tried, "loaded": loaded, "none": int(loaded == 0)})
        refused.update(outcomes)
        reasons = "; ".join(f"{count} {reason}" for reason, count in outcomes.most_common())
        print(f"| {path.relative_to(folder).as_posix()} | {tried} | {loaded} | {reasons} |", flush=True)
    share = 100.0 * totals["loaded"] / max(totals["tried"], 1)
    print(
        f"\n{totals['maps']} maps, {totals['tried']} directions, {totals['loaded']} loaded ({share:.1f} %), "
        f"{totals['none']} maps in no direction\n\n| refused | directions |\n|---|---|"
    )
    for reason, count in refused.most_common():
        print(f"| {reason} | {count} |")


def _outcomes(path: Path) -> Iterator[str]:
    """What comes of each road in each direction."""
    try:
        network = Network(path, "table")
    except InputError as error:
        yield _reason(error)
        return
    for road in network.roads.values():
        for forward in (True, False):
            yield _outcome(network, Leg(road, forward))


def _outcome(network: Network, leg: Leg) -> str:
    try:
        if not leg.is_drivable:
            return "no driving lane"
        direction: Direction = "forward" if leg.forward else "backward"
        wanted = OpenDriveRoad(opendrive="", route=(leg.road.id,), direction=direction)
        road = build(Road, route_table(network, wanted, network.file, {}), network.file)
        if fault := next(road_faults(road), None):
            raise InputError(f"{network.file}: {fault}")
    except InputError as error:
        return _reason(error)
    return "loaded"


def _reason(error: InputError) -> str:
    """A message without its place and numbers."""
    said = re.sub(r"^.*?(?=expected)", "", str(error).splitlines()[0], flags=re.DOTALL)
    return (
        re.sub(r"(, [\d.]+ m)?,? got .*$", "", said)
        .replace("expected ", "no ", 1)
        .replace("no a ", "no ", 1)
        .replace("|", "/")
    )


if __name__ == "__main__":
    main()
