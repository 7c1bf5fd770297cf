"""pytest plugin: ``pytest --dem-harness`` makes each check an item of the user's own suite.

The fixture ``dem_verification`` is the same verification, for assertions of one's
own; it needs no option. A verification runs once in a session; under xdist one
worker runs it and the others wait for what it found.

pytest loads this module in every session of an environment that has it:
nothing but pytest and the standard library is imported here.
"""

from __future__ import annotations

import pickle
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import pytest

if TYPE_CHECKING:
    from harness.comparison.verdicts import Check
    from harness.comparison.verification import Verification

OPTIONS = {
    "engine": "the engine to verify, as of dem-harness verify  [default: lammps]",
    "engines": "other engines to hold beside it, names with commas, or all",
    "lmp": 'a LAMMPS executable of your own, as "lmp" or "lmp -sf omp"; else it runs in-process',
    "mpirun": 'an MPI launcher with its options, as in "mpirun -np 4"',
    "integrator": "of the reference engine, as of dem-harness verify",
    "level": "quick, default or full  [default: quick]",
    "cases": "names or groups of cases, with commas, or all  [default: as dem-harness verify]",
    "only": "a shell-style pattern: run the cases, submodels, systems or checks that match",
    "program": "NAME=PATH: the executable of an engine; repeat it for several",
    "engine_option": "NAME.KEY=VALUE: an option of an engine's class; repeat it for several",
}
"""Each an option ``--dem-harness-NAME`` and an ini setting ``dem_harness_NAME``."""

REPEATED = ("program", "engine_option")
"""Those of several values, in an ini file a line each."""

MARK = "dem_harness"
_FOUND = pytest.StashKey["Verification"]()


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the options and their ini settings."""
    group = parser.getgroup("dem-harness", "verification of a DEM code (dem-harness)")
    group.addoption(
        "--dem-harness",
        action="store_true",
        help="run a verification and make each of its checks a test",
    )
    for name, text in OPTIONS.items():
        several = name in REPEATED
        how = "append" if several else "store"
        kind: Literal["linelist", "string"] = "linelist" if several else "string"
        option = f"--dem-harness-{name.replace('_', '-')}"
        group.addoption(option, metavar=name.upper(), action=how, default=None, help=text)
        parser.addini(f"dem_harness_{name}", text, type=kind, default="")


def pytest_configure(config: pytest.Config) -> None:
    """Name the mark that the checks carry."""
    config.addinivalue_line("markers", f"{MARK}: a check of dem-harness (--dem-harness)")


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(
    session: pytest.Session, config: pytest.Config, items: list[pytest.Item]
) -> None:
    """Add the checks, before -k, -m and others choose among the items."""
    if not config.getoption("dem_harness"):
        return
    parent = Verified.from_parent(session, name="dem-harness", nodeid="dem-harness")
    # what there is to check is known only after a run
    only_listed = config.option.collectonly
    checks = (
        [UnlistedChecks.from_parent(parent, name="verification")]
        if only_listed
        else parent.collect()
    )
    kept_items: list[pytest.Item | pytest.Collector] = [*checks]
    items += (item for item in kept_items if isinstance(item, pytest.Item))
    # collection is over: who counts what was collected has not seen these
    report = pytest.CollectReport(parent.nodeid, "passed", None, kept_items)
    config.hook.pytest_collectreport(report=report)


@pytest.fixture(scope="session")
def dem_verification(request: pytest.FixtureRequest) -> Verification:
    """Return the verification of this session: its checks, evidence and ``to_frame()``."""
    try:
        return verification(request.config)
    except CannotVerifyError as error:
        pytest.fail(str(error), pytrace=False)


def verification(config: pytest.Config) -> Verification:
    """Return the session's verification, run when it is first asked for.

    Raise CannotVerifyError, in the words of the harness, for options that are wrong
    and for an engine that cannot be run.
    """
    if _FOUND not in config.stash:
        shared = _shared_folder(config)
        config.stash[_FOUND] = _run_once(config, shared) if shared else _run(config)
    return config.stash[_FOUND]


class Verified(pytest.Collector):
    """The verification, which gives its checks."""

    def collect(self) -> Iterable[pytest.Item]:
        """Yield an item for each check; a name that comes again in its kind is numbered."""
        try:
            checks = verification(self.config).checks
        except CannotVerifyError as error:
            yield UnlistedChecks.from_parent(self, name="verification", error=error)
            return
        seen: Counter[str] = Counter()
        for check in checks:
            name = f"{check.kind}: {check.name}"
            seen[name] += 1
            again = f" ({seen[name]})" if seen[name] > 1 else ""
            yield Item.from_parent(self, name=name + again, check=check)


class _Placed(pytest.Item):
    def reportinfo(self) -> tuple[Path, int | None, str]:
        """Return a place, and the name: bare, pytest would write its dots as ``::``."""
        return self.config.rootpath / "dem-harness", None, f"dem-harness: {self.name}"


class UnlistedChecks(_Placed):
    """Stands for all checks where there are none: not run yet, or not to be run."""

    def __init__(self, *, error: CannotVerifyError | None = None, **rest: Any) -> None:
        super().__init__(**rest)
        self.error = error

    def runtest(self) -> None:
        """Fail when there can be no verification."""
        if self.error:
            pytest.fail(str(self.error), pytrace=False)


class Item(_Placed):
    """One check as a test."""

    def __init__(self, *, check: Check, **rest: Any) -> None:
        super().__init__(**rest)
        self.check = check
        self.add_marker(MARK)

    def runtest(self) -> None:
        """Fail, skip or pass as the check does; a known defect is a failure that is expected."""
        self.user_properties.append(("kind", str(self.check.kind)))
        from harness.report.text import numbers

        self.add_report_section("call", "dem-harness", numbers(self.check))
        if self.check.verdict == "known defect":
            pytest.xfail(self.check.note)
        if self.check.verdict in ("not tested", "fixed"):
            pytest.skip(f"{self.check.verdict}: {self.check.note}")
        if self.check.verdict == "fail":
            raise CheckFailedError(self.check)

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], *_: Any) -> Any:
        """Return what failed in words and numbers, without a traceback."""
        if isinstance(excinfo.value, CheckFailedError):
            return _story(excinfo.value.check)
        return super().repr_failure(excinfo)


class CannotVerifyError(Exception):
    """The verification cannot be run as it was asked for."""


class CheckFailedError(AssertionError):
    """A check whose verdict is fail."""

    def __init__(self, check: Check) -> None:
        super().__init__(f"{check.name}{': ' if check.note else ''}{check.note}")
        self.check = check


def _story(check: Check) -> str:
    if check.engine_died:
        return "\n".join(filter(None, (f"{check.name}: {check.note}", check.log[-2000:].strip())))
    rows = {
        "value": f"{check.value:.10g} {check.unit}",
        "expected": f"{check.expected:.10g} {check.unit}",
        "difference": f"{check.difference:.3g}",
        "tolerance": f"{check.tolerance:.3g}" + (f"  ({check.why})" if check.why else ""),
        "uncertainty": f"{check.uncertainty:.3g}",
        "class": check.triage,
        "note": check.note,
    }
    first = f"{check.name}: {abs(check.difference):.3g} apart, {check.tolerance:.3g} allowed"
    lines = (f"  {name:<12}{text}".rstrip() for name, text in rows.items() if text)
    return "\n".join([first, *lines])


def _run(config: pytest.Config) -> Verification:
    import warnings

    from harness.errors import HarnessError
    from harness.workflows.verification import Selection, verify_as_typed

    requested = {
        n: config.getoption(f"dem_harness_{n}") or config.getini(f"dem_harness_{n}") or None
        for n in OPTIONS
    }
    try:
        # warnings of a library below are not the user's, who may have made them errors
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            cases, only = requested.pop("cases"), requested.pop("only") or ""
            chosen = Selection(cases, only, config.option.keyword)
            return verify_as_typed(**requested, cases=chosen)
    except HarnessError as error:
        raise CannotVerifyError(f"dem-harness: {error}") from None


def _shared_folder(config: pytest.Config) -> Path | None:
    """Return the folder that the xdist workers of this session share; None without xdist."""
    if not hasattr(config, "workerinput"):
        return None
    factory: pytest.TempPathFactory = config._tmp_path_factory  # type: ignore[attr-defined]
    return factory.getbasetemp().parent


def _run_once(config: pytest.Config, folder: Path) -> Verification:
    """Return what the first worker found; the others wait for it at a lock."""
    from harness.engines.process import MADE, held

    run = config.workerinput["testrunuid"]  # type: ignore[attr-defined]
    kept = folder / f"dem-harness-{run}.pickle"
    with held(kept, MADE):
        if not kept.exists():
            outcome: Verification | str
            try:
                outcome = _run(config)
            except CannotVerifyError as error:
                outcome = str(error)
            aside = kept.with_suffix(".part")
            aside.write_bytes(pickle.dumps(outcome))
            aside.rename(kept)
    outcome = pickle.loads(kept.read_bytes())
    if isinstance(outcome, str):
        raise CannotVerifyError(outcome)
    return outcome
