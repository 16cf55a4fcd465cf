"""Seeds of a run as text: "A:B" is A to B without B, commas join ranges and single seeds, as in "0:5,9"."""

from collections.abc import Iterable, Sequence
from itertools import chain, islice
from operator import index

from vpf_sim.errors import InputError, shown

MOST_DIGITS = 18  # of a seed
MOST_SEEDS = 1_000_000  # of one run: more is a typing error and does not fit into memory


def parse_seeds(text: str, where: str = "--seeds") -> Sequence[int]:
    """The seeds that a text names, in its order."""
    parts = text.split(",")
    ranges = [_range(part, text, where, is_listed=len(parts) > 1) for part in parts]
    if sum(found.stop - found.start for found in ranges) > MOST_SEEDS:
        raise InputError(f"{where}: expected at most {MOST_SEEDS} seeds, got '{text[:60]}'")
    return ranges[0] if len(ranges) == 1 else _distinct(chain(*ranges), where)


def seeds_text(seeds: Iterable[int], where: str) -> str:
    """The text of seeds, such as "3:6,9" for 3, 4, 5 and 9; InputError where they are none."""
    try:
        given = [_seed(seed) for seed in islice(seeds, MOST_SEEDS + 1)]
    except (TypeError, ValueError):
        raise InputError(f"{where}: expected whole numbers of up to {MOST_DIGITS} digits, got {shown(seeds)}") from None
    if not 0 < len(given) <= MOST_SEEDS:
        raise InputError(f"{where}: expected 1 to {MOST_SEEDS} seeds, got {shown(seeds)}")
    runs: list[list[int]] = []
    for seed in _distinct(given, where):
        if runs and seed == runs[-1][-1] + 1:
            runs[-1].append(seed)
        else:
            runs.append([seed])
    is_one = len(runs) == 1
    return ",".join(str(run[0]) if len(run) == 1 and not is_one else f"{run[0]}:{run[-1] + 1}" for run in runs)


def _range(part: str, text: str, where: str, is_listed: bool) -> range:
    """The seeds of "A:B", or of "A" in a list."""
    first, colon, last = part.strip().partition(":")
    if is_listed and not colon:
        colon, last = ":", str(int(first) + 1) if _is_number(first) else ""
    if not (colon and _is_number(first) and _is_number(last)):
        form = "A:B and whole numbers, such as 0:5,9" if is_listed else "A:B with whole numbers, such as 1000:1030"
        raise InputError(f"{where}: expected {form}, got '{text[:60]}'")
    seeds = range(int(first), int(last))
    if not seeds:
        raise InputError(f"{where}: expected A:B with A below B, got '{part[:60]}', which holds no seed")
    return seeds


def _is_number(text: str) -> bool:
    return text.isdecimal() and len(text) <= MOST_DIGITS


def _seed(value: object) -> int:
    """A seed as Python's own number, also of numpy's; TypeError or ValueError for anything else."""
    if isinstance(value, bool):
        raise TypeError
    seed = index(value)  # type: ignore[arg-type]  # raises TypeError where it is none
    if not 0 <= seed < 10**MOST_DIGITS:
        raise ValueError
    return seed


def _distinct(seeds: Iterable[int], where: str) -> tuple[int, ...]:
    """The seeds; InputError where one is named twice."""
    given: dict[int, None] = {}
    for seed in seeds:
        if seed in given:
            raise InputError(f"{where}: expected different seeds, got {seed} twice")
        given[seed] = None
    return tuple(given)
