"""``dem-harness cases``."""

from __future__ import annotations

from harness.cli.command import Json
from harness.cli.files import print_json, print_wrapped


def cases(*, json: Json = False) -> int:
    """List the cases: what each simulates, its quantities, and the engines that state it.

    For example:

        dem-harness cases
        dem-harness cases --json
    """
    from harness.cases.registry import faults
    from harness.store.entries import tell_stderr
    from harness.workflows import cases as ask

    for fault in faults():
        tell_stderr(fault)
    found = [case.record() for case in ask()]
    if json:
        print_json({"cases": found})
        return 0
    for case in found:
        print_wrapped(f"{case['name']} ({case['group']}): {case['summary']}")
        quantities = (f"{name} ({unit or '-'})" for name, unit in case["quantities"].items())
        print_wrapped(f"quantities: {', '.join(quantities)}", indent=4)
        print_wrapped(f"parameters: {', '.join(case['parameters'])}", indent=4)
        print_wrapped(f"engines: {', '.join(case['engines']) or 'none'}", indent=4)
    return 0
