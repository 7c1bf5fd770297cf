from dataclasses import replace

import numpy as np
import pytest

from harness.comparison.series import Comparison
from harness.comparison.verdicts import Kind, Tolerance, failed_run, finding, judge, not_tested
from harness.comparison.verification import DeclaredEngine, Findings, Verification
from harness.errors import EngineTimeoutError
from harness.observables.provenance import Provenance
from harness.observables.row import Row
from harness.report.sections import Drawing, Section, Table
from harness.report.style import label, panels

ENGINE = Provenance("toy", "1 Jan 2030", ("A", "B"), "/bin/toy", "executable")
WIDTH = Tolerance("deg", 3e-4, 0.0, "a reason")
TIME = np.linspace(0.0, 1.0, 501)
DIVERGED = Comparison(
    "slope", "x_m", TIME, TIME**2 + np.where(TIME > 0.6, TIME - 0.6, 0.0), TIME**2, 1e-9
)
HOSTILE = "<script>alert(1)</script> ![x](http://h/x.png) | `a` \x1b[31mred\x07 @you"
"""What an engine or a plug-in may call something."""


def _hung():
    error = EngineTimeoutError("5 s")
    error.log = "# toy -in slope.in -var angle 10.2\nStep 1 <&> 2\n"
    return error


@pytest.fixture(scope="session")
def verification():
    """A verification with every kind of row, made up."""
    told = Row("critical angle", 10.206981, 0.00042, "deg", 10.2078187, "toy", "step to 0")
    return Verification(
        level="quick",
        cases=("slope", "ball"),
        started="2030-01-01T00:00:00+00:00",
        seconds=1.5,
        platform="a test",
        harness_version="0",
        provenance=ENGINE,
        checks=(
            judge("angle <holds>", Kind.ANALYTIC, 10.2, 10.2001, WIDTH),
            judge("angle | fails", Kind.ANALYTIC, 10.2, 10.3, WIDTH),
            failed_run("a run that hung", Kind.CROSS_CODE, _hung()),
            not_tested("no engine", Kind.CROSS_CODE, "not installed"),
            finding("laws differ", 1.0, 2.0, "deg", "as they should"),
        ),
        main={"slope": Findings("slope", "toy", headlines=[told])},
        solvers={"slope": Findings("slope", published={"slope_rows": [1, 2]})},
        scripts={"slope.in": "run 0\n"},
        engine_errors=("out of time: 5 s",),
        logs={"slope.in": "# toy -in slope.in\nTotal wall time: 0:00:01\n"},
    )


def _declared(engine, **others):
    return DeclaredEngine(
        engine, "1.2" if not others.get("missing") else "", "executable", "apt install", ("1.2",),
        "velocity-verlet", ("clipped",), ("full", "half"), 15,
        **{"lineage": "", "caveats": (), **others},
    )  # fmt: skip


@pytest.fixture(scope="session")
def declared():
    """Engines beside one another: two that hold, one missing, one not qualified."""
    return (
        _declared("one", caveats=("It <always> clips.", "It counts m/2.")),
        _declared("two", lineage="one"),
        _declared("three", missing="no three here"),
        _declared("four", unqualified="free fall"),
    )


@pytest.fixture(scope="session")
def hostile(verification, declared):
    """The same where everything that an engine or a case names is hostile."""
    check = replace(verification.checks[1], name=HOSTILE, note=HOSTILE)
    told = Row(HOSTILE, 1.1, 0.1, HOSTILE, 1.0, HOSTILE, HOSTILE)
    return replace(
        verification,
        checks=(check, failed_run(HOSTILE, Kind.ANALYTIC, _hung())),
        main={"slope": Findings("slope", "toy", headlines=[told])},
        provenance=replace(ENGINE, engine=HOSTILE, engine_version=HOSTILE, executable=HOSTILE),
        engines=(replace(declared[0], engine=HOSTILE, caveats=(HOSTILE,)),),
        scripts={"../../up/<s>.in": HOSTILE},
        logs={"../../up/<s>.in": HOSTILE},
    )


def draw(rows=1, columns=1):
    """Return what draws a sine into each of rows by columns axes."""

    def sine():
        figure = panels(rows, columns)
        for axes in figure.axes:
            axes.plot(TIME, np.sin(TIME))
            label(axes, "time (s)", "force (N)")
        return figure

    return sine


@pytest.fixture(scope="session")
def sections():
    """Two sections with a title, and one whose figures go to the gallery."""
    table = Table(
        "Angles",
        "Angles of every contact.",
        ("contact", "angle (deg)", "remark"),
        (("plastic", "10.2070", "holds"), ("source | kept", "10.2060", "<b>not</b> bold")),
    )
    return [
        Section(
            "The slope",
            ("A <b>sentence</b> of the case.",),
            ("an item", "another"),
            (table,),
            (
                Drawing("one", "One", "A usual figure.", draw()),
                Drawing("two", "Two", "Another.", draw()),
                Drawing("odd", "Odd", "A third.", draw()),
                Drawing("broad", "Broad", "Three panels.", draw(1, 3)),
                Drawing("four-rows", "Four rows", "Tall.", draw(4, 2)),
            ),
        ),
        Section("The ball", tables=(table,)),
        Section(drawings=(Drawing("extra", "Extra", "Of the gallery.", draw()),)),
    ]
