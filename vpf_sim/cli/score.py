"""`vpf-sim score`: recompute the scores of a run from its steps."""

from typing import TYPE_CHECKING

from vpf_sim.cli.options import JsonOption, RunArgument, print_json, prints_on_stderr

if TYPE_CHECKING:
    from vpf_sim.evaluation.analysis.rescore import Rescored

MOST = 20  # listed changed records


def score(run: RunArgument, json: JsonOption = False) -> None:
    """Recompute a run's scores from its stored steps.

    Nothing is driven; records whose scores changed are stored.
    """
    from vpf_sim.evaluation.analysis.rescore import rescore

    with prints_on_stderr():
        done = rescore(run)
    if json:
        changed = [{"id": name, "keys": keys} for name, keys in sorted(done.changed.items())]
        print_json({"out": str(run), "scored": len(done.records), "changed": changed, **done.summary.as_json()})
    else:
        _print(done)


def _print(done: "Rescored") -> None:
    from vpf_sim.cli.results import print_benchmark, print_comparisons, print_rows

    if done.command == "benchmark":
        print_benchmark(done.summary.rows, done.seeds)
    else:
        print_rows(done.summary.rows)
        print_comparisons(done.summary.comparisons)
    print(f"\n{len(done.records)} of {done.planned} planned episodes rescored, {len(done.changed)} changed")
    for name, keys in sorted(done.changed.items())[:MOST]:
        print(f"  {name}: {', '.join(keys)}")
    if len(done.changed) > MOST:
        print(f"  and {len(done.changed) - MOST} more")
