"""Results of the verbs in a notebook: a few lines, a table, a figure; engines by their names."""

from dataclasses import replace

import pandas as pd
import pytest
from matplotlib.figure import Figure

from harness import workflows
from harness.cases.incline.angle import CriticalAngle, Sample, extrapolate
from harness.cases.incline.system import Incline
from harness.comparison.regression import BaselineRecord
from harness.comparison.releases import Column, release_matrix
from harness.comparison.run_diff import diff_runs
from harness.comparison.verdicts import Kind, Tolerance
from harness.engines.reference import Reference
from harness.errors import RequestError
from harness.observables.provenance import Provenance
from harness.observables.row import Row
from harness.parameters.law import PLASTIC
from harness.parameters.tower import Tower
from harness.reproduction.claims import SOURCES, Ledger, untestable
from harness.reproduction.run import Reproduction
from harness.workflows.baseline import BaselineComparison
from harness.workflows.sweep_run import Sweep

PACKAGES = Provenance("toy", "1 Jan 2030", tuple(f"PACKAGE-{n}" for n in range(200)), how="made up")
LINES = 5


def angle(stiffness=1e6, steps=50.0, value=10.2):
    samples = [Sample(10.1, 0.0, "trapped", -0.1), Sample(10.3, 0.0, "moves_on", 0.1)]
    case = Incline(contact=PLASTIC, stiffness=stiffness, steps_per_contact=steps)
    return CriticalAngle(value, 4e-4, 1e-4, "passage", case, PACKAGES, tuple(samples))


def ladder():
    return extrapolate(
        [
            angle(k, n, 10.2078 - 1e3 / k - 0.1 / n)
            for k in (1e5, 1e6, 1e7, 1e8)
            for n in (50.0, 100.0, 200.0)
        ]
    )


def against_baseline(found):
    row = replace(found.checks[0], kind=Kind.REGRESSION)
    return replace(found, checks=(*found.checks, row))


def releases():
    def column(name, value):
        force = {"peak_force_N": Row("peak_force_N", value, 0.0, "N")}
        record = BaselineRecord("tower", {}, force, "toy", "1", case="tower")
        return Column(name, Provenance("toy", name), (record,))

    allowed = {"tower": {"peak_force_N": Tolerance("N", 1e-6, 0.0, "a reason")}}
    return release_matrix("quick", "Linux", [column("1", 1.0), column("2", 1.1)], allowed, "TOY")


def reproduction():
    statement = next(source for source in SOURCES.values() if source.untestable)
    parts = dict.fromkeys(("figures", "findings"), None)
    return Reproduction(
        Ledger((untestable(statement),)), **parts, provenance=PACKAGES, platform="x",
        harness_version="0",
    )  # fmt: skip


MADE = {
    "theory": lambda _: workflows.theory(restitution=0.1),
    "critical_angle": lambda _: angle(),
    "critical_angle, steady": lambda _: replace(
        angle(), samples=(Sample(10.2, 0.0, "undecided", float("nan")),)
    ),
    "extrapolated_critical_angle": lambda _: ladder(),
    "tower": lambda _: workflows.tower(Tower(height=2), solver="exact"),
    "run": lambda _: workflows.run("tower", {"height": "2"}, "exact"),
    "sweep": lambda _: Sweep(
        "tower",
        tuple({"engine": "exact", "height": n, "force_N": n, "status": "done"} for n in (1, 2)),
        ("height",),
        ("force_N",),
    ),
    "verify": lambda found: found,
    "compare_with_baseline": lambda found: BaselineComparison(against_baseline(found), ()),
    "diff": lambda found: diff_runs(found.results, replace(found, seconds=2.0).results),
    "releases": lambda _: releases(),
    "reproduce": lambda _: reproduction(),
}
LONGER = {"run", "releases"}
"""Of which each quantity or release is a line."""


@pytest.mark.parametrize("verb", MADE)
def test_a_result_shows_itself_in_five_lines_and_draws_itself_with_units(verb, verification):
    found = MADE[verb](replace(verification, provenance=PACKAGES))
    shown = found._repr_html_()
    assert shown.count("<tr>") <= LINES or verb in LONGER
    assert "PACKAGE" not in shown + repr(found)
    assert max(len(shown), len(repr(found))) < 1500
    assert isinstance(found.to_frame(), pd.DataFrame)
    assert not found.to_frame().empty
    figure = found.plot()
    assert isinstance(figure, Figure)
    assert figure.axes[-1].get_xlabel()
    assert all(axes.get_ylabel() for axes in figure.axes)
    assert figure._repr_png_().startswith(b"\x89PNG")


def test_names_of_engines_are_text_not_markup(verification, hostile):
    assert "<script>" not in hostile._repr_html_()
    assert verification._repr_html_() != hostile._repr_html_()


def test_an_engine_is_opened_by_its_name_and_what_it_ran_is_kept(monkeypatch):
    first = workflows.critical_angle(engine="reference", phases=1)
    assert first.provenance.engine == "reference"

    def run(*_):
        raise AssertionError("it was kept")

    monkeypatch.setattr(Reference, "run", run)
    assert workflows.critical_angle(engine="reference", phases=1).value_deg == first.value_deg
    with pytest.raises(AssertionError, match="kept"):
        workflows.critical_angle(engine="reference", phases=1, fresh=True)


def test_a_tower_is_run_by_its_own_solver_unless_an_engine_is_named():
    assert workflows.tower(Tower()).solver == "rk4"
    for named in ({"engine": "reference"}, {"solver": "reference"}):
        with pytest.raises(RequestError, match="engine 'reference' cannot run 'tower'"):
            workflows.tower(Tower(law="overlap"), **named)


def test_a_name_that_is_no_engine_is_a_request_error():
    with pytest.raises(RequestError, match="'nothing' is not known"):
        workflows.critical_angle(engine="nothing")
