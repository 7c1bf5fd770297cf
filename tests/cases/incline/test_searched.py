"""The critical angle as a quantity: in ``run`` and ``sweep``, as the search itself finds it."""

import math

import pytest

from harness.cases.columns.system import Columns
from harness.cases.columns.system import critical_angle as over_columns
from harness.cases.incline.angle import critical_angle
from harness.cases.incline.system import Incline
from harness.cases.registry import get_case
from harness.engines.reference import Reference
from harness.errors import EngineCrashError, RequestError
from harness.parameters.law import PLASTIC
from harness.solvers.hard_sphere import critical_angle as rigid
from harness.store.cache import CachedEngine
from harness.store.entries import Entries
from harness.theory.incline import critical_angle as closed_form
from harness.workflows import run, sweep
from harness.workflows.sweep_plan import SweepRequest, plan
from harness.workflows.sweep_run import measured

ANGLE = "critical_angle_deg"
SOFT = {"preset": "plastic", "stiffness": "1e4", "starts": "2"}


def test_a_sweep_has_the_angle_that_the_search_finds_and_its_uncertainty():
    found = sweep(
        "incline", {"stiffness": "1e4,1e5"}, fixed={"preset": "plastic"}, engines="reference",
        quantities=[ANGLE, "uncertainty_deg"],
    )  # fmt: skip
    assert found.selected == (ANGLE, "uncertainty_deg")
    for row in found.rows:
        case = Incline(contact=PLASTIC, steps_per_contact=100.0, stiffness=row["stiffness_N_per_m"])
        one = critical_angle(case, engine=Reference())
        assert (row[ANGLE], row["uncertainty_deg"]) == (one.value_deg, one.uncertainty_deg)
        assert (row["runs"], row["monotone"], row["method"]) == (len(one.samples), 1.0, "passage")
        assert row["status"] == "done"
        assert "angle_deg" not in row
        assert "phase" not in row
    bars = found.figure().axes[0].containers[0]
    assert len(bars[2][0].get_segments()) == 2


def test_by_steady_motion_as_well():
    fixed = {**SOFT, "method": "steady", "wells": "3"}
    found = sweep("incline", {"tolerance": [0.1]}, fixed=fixed, engines="reference",
                  quantities=ANGLE)  # fmt: skip
    case = Incline(contact=PLASTIC, steps_per_contact=100.0, stiffness=1e4, wells=3)
    one = critical_angle(case, method="steady", tolerance_deg=0.1, engine=Reference())
    assert found.rows[0][ANGLE] == one.value_deg


def test_columns_have_it_too():
    settings = {**SOFT, "n": "2"}
    found = run("columns", settings, "reference", quantities=ANGLE)
    case = Columns(contact=PLASTIC, steps_per_contact=100.0, stiffness=1e4, n=2)
    assert found.quantities[ANGLE].value == over_columns(case, Reference()).value_deg
    assert found.quantities[ANGLE].expected == pytest.approx(closed_form())
    assert list(found.quantities) == [ANGLE]
    assert "angle" not in found.parameters


def test_rigid_spheres_are_a_solver_and_what_is_expected():
    over = {"contact.restitution": "0,0.1,0.5,0.8"}
    found = sweep("incline", over, engines="hard-sphere", quantities=ANGLE)
    assert [row[ANGLE] for row in found.rows[:3]] == [rigid(0.0), rigid(0.1), rigid(0.5)]
    assert (found.rows[3]["status"], found.rows[3][ANGLE]) == ("not tested", None)
    (line,) = [one for one in found.figure().axes[0].get_lines() if len(one.get_xdata()) > 60]
    assert line.get_xdata()[-1] <= 0.7  # none above, where the grain flies
    assert line.get_ydata()[0] == pytest.approx(closed_form(), abs=1e-9)
    assert max(line.get_ydata()) == pytest.approx(rigid(max(line.get_xdata())))


@pytest.mark.parametrize("name", ["angle", "phase"])
def test_what_is_searched_over_can_be_neither_swept_nor_set(name):
    with pytest.raises(RequestError, match=f"over {name}=.*{name}: {ANGLE} is searched for over"):
        plan(SweepRequest("incline", ({name: "0.1,0.2"},), {}, "reference", ANGLE))
    with pytest.raises(RequestError, match=f"set: {name}: {ANGLE} is searched for"):
        run("columns", {name: "0.1"}, "reference", quantities=ANGLE)


@pytest.mark.parametrize(
    ("quantity", "said"),
    [
        ("mass", "--quantity 'mass': case 'incline' measures margin_over_mgd, .*critical_angle"),
        (f"touching,{ANGLE}", "not of the same runs; must be some of margin_over_mgd.* or of crit"),
    ],
)
def test_other_quantities_are_refused_with_those_that_there_are(quantity, said):
    with pytest.raises(RequestError, match=said):
        plan(SweepRequest("incline", ({"stiffness": "1e5"},), {}, "", quantity))
    with pytest.raises(RequestError, match=said):
        run("incline", quantities=quantity.split(","))


def test_a_contact_that_a_passage_cannot_measure_is_not_tested_with_what_to_set():
    over = {"contact.restitution": "0.1,0.5"}
    fixed = {"stiffness": 1e5, "starts": 1}
    rows = sweep("incline", over, fixed=fixed, engines="reference", quantities=ANGLE).rows
    assert [row["status"] for row in rows] == ["done", "not tested"]
    assert "use --set method=steady" in rows[1]["reason"]
    assert math.isfinite(rows[0][ANGLE])


def test_an_engine_that_states_no_such_case_is_not_tested_and_one_that_dies_has_failed():
    case = get_case("columns").measuring([ANGLE])
    parameters = case.presets["plastic"]

    class Refusing(Reference):
        def refuses(self, job):  # noqa: ARG002
            return "not this one"

    class Dying(Reference):
        def run(self, jobs):
            return [EngineCrashError("dead")] * len(jobs)

    assert str(measured(case, parameters, Refusing())) == "not this one"
    assert isinstance(measured(case, parameters, Dying()), EngineCrashError)


class Counting(Reference):
    """Counts its runs, and dies after so many."""

    def __init__(self, most=10**9):
        super().__init__()
        self.count, self.most = 0, most

    def run(self, jobs):
        self.count += len(jobs)
        if self.count > self.most:
            raise KeyboardInterrupt
        return super().run(jobs)


def test_a_search_that_was_cut_goes_on_with_the_runs_that_it_made(tmp_path):
    case = get_case("incline").measuring([ANGLE])
    parameters = case.presets["plastic"].replace(stiffness=1e4)
    entries, whole, cut, rest = Entries(tmp_path), Counting(), Counting(3), Counting()
    expected = measured(case, parameters, whole)
    with pytest.raises(KeyboardInterrupt):
        measured(case, parameters, CachedEngine(cut, entries))
    found = measured(case, parameters, CachedEngine(rest, entries))
    assert found.values == expected.values
    assert 0 < rest.count < whole.count
    again = Counting()
    assert measured(case, parameters, CachedEngine(again, entries)).values == expected.values
    assert again.count == 0
