"""`vpf-sim doctor`: checks of this machine."""

import sys
from dataclasses import asdict

import typer

from vpf_sim.cli.options import JsonOption, print_json, prints_on_stderr


def doctor(json: JsonOption = False) -> None:
    """Check this machine; exit code 1 if a check fails.

    Checked are installation, frames, speed and reproducibility.
    """
    from vpf_sim.machine.doctor import examine

    answer, checks = sys.stdout, []
    with prints_on_stderr():
        for check in examine():
            checks.append(check)
            if not json:
                remedy = f"; {check.remedy}" if check.remedy else ""
                line = f"{'ok' if check.ok else 'FAIL':<6}{check.name:<16}{check.found}{remedy}"
                print(line, file=answer, flush=True)
    all_ok = all(check.ok for check in checks)
    if json:
        print_json({"ok": all_ok, "checks": [asdict(check) for check in checks]})
    raise typer.Exit(0 if all_ok else 1)
