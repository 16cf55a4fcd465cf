"""Said loudly: episodes that ended because the camera gave no picture."""

import sys
from collections.abc import Iterable
from typing import Any

MOST = 20  # lines, in a run that has more of them
WORDS = {
    "black": "all black",
    "constant": "of one colour",
    "wrong shape": "of the wrong shape",
    "stale": "the same as the one before although the car had moved more than 2 cm",
}


def warn(records: Iterable[dict[str, Any]]) -> None:
    """A warning on stderr for each episode among `records` that an invalid frame ended."""
    ended = [record for record in records if record["status"] == "invalid_frame"]
    for record in ended[:MOST]:
        print(f"vpf-sim: WARNING: {record['id']}: {sentence(record)}", file=sys.stderr)
    if len(ended) > MOST:
        print(f"vpf-sim: WARNING: and {len(ended) - MOST} more episodes with an invalid frame", file=sys.stderr)
    if ended:
        print("vpf-sim: WARNING: the camera is broken, the scores of such episodes mean nothing", file=sys.stderr)


def sentence(record: dict[str, Any]) -> str:
    """Which frame it was and what was wrong with it."""
    invalid = record["invalid_frame"]
    return f"invalid frame {invalid['frame']}, at {invalid['time_s']:.3f} s: {WORDS[invalid['fault']]}"
