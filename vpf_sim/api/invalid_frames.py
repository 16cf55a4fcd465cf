"""Warnings for episodes that ended by an invalid camera frame."""

import sys
from collections.abc import Iterable
from typing import Any

MOST = 20  # printed lines
WORDS = {
    "black": "all black",
    "constant": "of one colour",
    "wrong shape": "of the wrong shape",
    "stale": "the same as the one before although the car had moved more than 2 cm",
}


def warn(records: Iterable[dict[str, Any]]) -> None:
    """Print a warning on stderr for each record that ended by an invalid frame."""
    ended = [record for record in records if record["status"] == "invalid_frame"]
    for record in ended[:MOST]:
        print(f"vpf-sim: WARNING: {record['id']}: {sentence(record)}", file=sys.stderr)
    if len(ended) > MOST:
        print(f"vpf-sim: WARNING: and {len(ended) - MOST} more episodes with an invalid frame", file=sys.stderr)
    if ended:
        print("vpf-sim: WARNING: the camera is broken; the scores of these episodes are invalid", file=sys.stderr)


def sentence(record: dict[str, Any]) -> str:
    """The number, time and fault of a record's invalid frame."""
    invalid = record["invalid_frame"]
    return f"invalid frame {invalid['frame']}, at {invalid['time_s']:.3f} s: {WORDS[invalid['fault']]}"
