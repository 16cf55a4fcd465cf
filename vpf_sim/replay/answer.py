"""The title of a replay's page, and what was measured on a drive in a sentence."""

from collections.abc import Sequence
from typing import Any

from vpf_sim.reporting.answer import listed
from vpf_sim.reporting.cells import formatted


def title(records: Sequence[dict[str, Any]]) -> str:
    """What the page shows: "What vpf commands on my_drive"."""
    if not records:
        return "No drive was replayed"
    return f"What {records[0]['driver']} commands on {listed([record['name'] for record in records])}"


def drive_of(record: dict[str, Any]) -> str:
    """Length of a drive, and the agreement of throttle and steering with the human's."""
    seconds = record["frames"] / record["rate_hz"] if record["rate_hz"] else 0.0
    length = f"{record['frames']} frames, {seconds:.0f} s"
    scores = record["accuracy"]
    if record["error"] is not None:
        return f"{length}: the driver failed at frame {record['error']['frame']}; not scored."
    if scores is None:
        return f"{length}: not scored, as nobody drove."
    found = [_agreement(scores, signal) for signal in ("steering", "throttle") if scores[signal] is not None]
    return f"{length}: {'; '.join(found) or 'not scored, as the human commands are not known'}."


def _agreement(scores: dict[str, Any], signal: str) -> str:
    own, idle = (formatted(one[signal]["range"], 1, percent=True) for one in (scores, scores["idle"]))
    return f"{signal} agrees with the human's to {own} % (a driver that does nothing: {idle} %)"
