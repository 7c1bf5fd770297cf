"""Every tolerance of every case says why it is what it is."""

import pkgutil
from importlib import import_module

from harness.cases.registry import built_in, get_case
from harness.comparison.verdicts import Tolerance


def tolerances_of(case):
    """Return the tolerances of a case: those of its modules, and of its baseline."""
    found = dict(get_case(case).verification.regression)
    home = import_module(f"harness.cases.{case.replace('-', '_')}")
    inside = pkgutil.iter_modules(getattr(home, "__path__", ()), f"{home.__name__}.")
    for module in (home.__name__, *(one.name for one in inside)):
        for name, value in vars(import_module(module)).items():
            if isinstance(value, Tolerance):
                found[name] = value
            elif isinstance(value, dict):
                found |= {f"{name}[{k}]": v for k, v in value.items() if isinstance(v, Tolerance)}
    return found


def test_every_tolerance_says_why():
    for case in built_in():
        assert tolerances_of(case), case
        for name, tolerance in tolerances_of(case).items():
            assert len(tolerance.reason) > 20, (case, name)
            assert tolerance.absolute >= 0.0 <= tolerance.relative, (case, name)
