"""Rows of a run that has a defect, whose defect is gone, or that is off by another size."""

from dataclasses import replace

import numpy as np
import pytest

from harness.cases.base import Check
from harness.cases.bench import Bench, job_key
from harness.cases.checks import run_checks
from harness.engines.base import Job, Template, scene_job
from harness.errors import EngineCrashError
from harness.model.conventions import Faults, Rules
from harness.results.defects import KnownDefect
from harness.results.rows import Failure, Kind, Tolerance, Verdict
from harness.solvers import reference
from tests.engine_doubles import Twin
from tests.solvers.reference.scenes import HERTZ, LINEAR, impact

ENTRY = {"name": "weak", "engine": "code", "laws": ["hertz*"], "until": "2024",
         "cause": "the dashpot has half of its mass", "upstream": "issue 1"}  # fmt: skip
WEAK = KnownDefect(**ENTRY, faults={"tsuji_effective_mass": True})
TSUJI = impact(HERTZ.replace(damping="tsuji", restitution=0.5), (0.1, 0.0, -0.3), 50, every=5)
SLIDING = impact(LINEAR, (0.1, 0.0, -0.3), 50, every=5)
NARROW = Tolerance(1e-9, 0.0, "round-off")


class Code(Twin):
    """An engine that is the reference with faults, other rules, or an error."""

    name = "code"

    def __init__(self, faults=None, rules=None, error=None, factor=1.0, how="compiled"):
        super().__init__(declared=Rules())
        self.how = how
        self.faults, self.behaves, self.error, self.factor = faults, rules, error, factor

    def identify(self):
        return replace(super().identify(), how=self.how)

    def _motion(self, scene):
        motion = reference.run(scene, self.behaves, self.faults)
        return self.error or replace(motion, velocity=motion.velocity * self.factor)


def weighted(motion, part):
    """Return a sum in which no two samples cancel."""
    array = getattr(motion, part)
    return float(np.sum(array * np.linspace(1.0, 2.0, array.size).reshape(array.shape)))


def checks_of(scene, setup):
    """Return two quantities against the reference, and two against closed forms."""
    job = scene_job(scene)
    common = {"setup": setup, "unit": "m/s", "tolerance": NARROW, "jobs": (job,)}
    exact = {**common, "kind": Kind.ANALYTIC}

    def sampled(part):
        return {"measure": lambda bench: weighted(bench.motion(job), part),
                "expected": lambda bench: weighted(bench.reference(scene), part)}  # fmt: skip

    law = weighted(reference.run(scene), "velocity")
    return [
        Check(quantity="v", **sampled("velocity"), **common),
        Check(quantity="x", **sampled("position"), **common),
        Check(quantity="v", check="law", **{**sampled("velocity"), "expected": law}, **exact),
        Check(quantity="steps", measure=lambda _: 100.0, expected=100.0, **exact),
    ]


def rows_of(engine, defects=(WEAK,), version="2023", scene=TSUJI, setup="hertz, tsuji, wall"):
    checks = checks_of(scene, setup)
    return run_checks("head-on", checks, Bench(engine), version=version, defects=defects)


def verdicts(rows):
    return [str(row.verdict) for row in rows]


TSUJI_FAULT = Faults(tsuji_effective_mass=True)


def test_a_run_that_holds_with_the_switch_is_the_known_defect_in_all_rows_that_fail():
    engine = Code(TSUJI_FAULT)
    rows = rows_of(engine)
    assert verdicts(rows) == ["known defect", "known defect", "known defect", "pass"]
    assert {row.defect for row in rows[:3]} == {"weak"}
    assert all(row.failure is Failure.NONE and WEAK.cause in row.note for row in rows[:3])
    assert len(engine.jobs) == 1  # all rows share a run, and no trial takes another


@pytest.mark.parametrize(
    ("defects", "version"),
    [((WEAK,), "2025"), ((), "2023"), ((WEAK.replace(engine="other"),), "2023"),
     ((WEAK.replace(laws=("hooke*",)),), "2023"), ((WEAK.replace(cases=("oblique",)),), "2023")],
)  # fmt: skip
def test_a_failure_elsewhere_stays_one(defects, version):
    assert verdicts(rows_of(Code(TSUJI_FAULT), defects, version)) == ["fail"] * 3 + ["pass"]


def test_another_size_and_a_closed_form_that_fails_alone_are_failures():
    rows = rows_of(Code(TSUJI_FAULT, factor=1.0 + 1e-6))
    assert verdicts(rows)[0] == "fail"
    assert not any(row.defect for row in rows)
    *checks, steps = checks_of(TSUJI, "hertz, tsuji, wall")
    checks.append(replace(steps, expected=99.0))
    bench = Bench(Code(TSUJI_FAULT))
    rows = run_checks("head-on", checks, bench, version="2023", defects=(WEAK,))
    assert verdicts(rows) == ["known defect"] * 3 + ["fail"]


@pytest.mark.parametrize("kind", [Kind.CROSS_CODE, Kind.ANALYTIC])
def test_a_search_with_the_value_of_the_switch_is_the_known_defect(kind):
    later = TSUJI.replace(step=0.9 * TSUJI.step)  # that a search runs after its first jobs
    law = weighted(reference.run(later), "velocity")
    expected = law if kind is Kind.ANALYTIC else lambda b: weighted(b.reference(later), "velocity")
    search = Check(
        setup="hertz, tsuji, wall", quantity="angle", unit="deg", tolerance=NARROW, kind=kind,
        measure=lambda b: weighted(b.motion(scene_job(later)), "velocity"), expected=expected,
        jobs=(scene_job(TSUJI), scene_job(SLIDING)),
    )  # fmt: skip

    def verdict(search, engine):
        (row,) = run_checks("head-on", [search], Bench(engine), version="2023", defects=(WEAK,))
        return str(row.verdict), row.defect

    assert verdict(search, Code(TSUJI_FAULT)) == ("known defect", "weak")
    assert verdict(search, Code(TSUJI_FAULT, factor=1.0 + 1e-6)) == ("fail", "")
    assert verdict(replace(search, expected=1.01 * law), Code()) == ("fail", "")


def test_a_run_that_holds_where_the_switch_moves_it_is_fixed():
    rows = rows_of(Code())
    assert verdicts(rows) == ["fixed", "fixed", "pass", "pass"]
    assert rows[0].defect == "weak"
    assert verdicts(rows_of(Code(), version="2025")) == ["pass"] * 4
    optional, how = (WEAK.replace(command="-sf weak"),), "executable, -sf weak"
    assert verdicts(rows_of(Code(how=how), optional)) == ["pass"] * 4  # some parts may be without
    with_option, without = Code(TSUJI_FAULT, how=how), Code(TSUJI_FAULT)
    assert verdicts(rows_of(with_option, optional)) == ["known defect"] * 3 + ["pass"]
    assert verdicts(rows_of(without, optional)) == ["fail"] * 3 + ["pass"]
    elsewhere = (WEAK.replace(unless="-sf weak"),)  # another style runs there, and may have it not
    assert verdicts(rows_of(Code(how=how), elsewhere)) == ["pass"] * 4
    assert verdicts(rows_of(with_option, elsewhere)) == ["fail"] * 3 + ["pass"]
    assert verdicts(rows_of(without, elsewhere)) == ["known defect"] * 3 + ["pass"]
    sliding = rows_of(Code(), (WEAK.replace(laws=("*",)),), scene=SLIDING, setup="hooke, wall")
    assert verdicts(sliding) == ["pass"] * 4  # the switch moves nothing here


def test_a_run_with_a_defect_that_cannot_be_computed_is_not_tested():
    open_ = KnownDefect(**ENTRY, undetermined="the order of contacts is not known")
    rows = rows_of(Code(TSUJI_FAULT), (open_,))
    assert verdicts(rows) == ["not tested"] * 3 + ["pass"]
    assert "order of contacts" in rows[0].note
    assert verdicts(rows_of(Code(), (open_,))) == ["pass"] * 4
    both = rows_of(Code(TSUJI_FAULT), (open_, WEAK.replace(name="switched")))
    assert rows[0].value == both[0].value
    assert both[0].defect == "switched"
    assert "whatever else may be wrong in this row is hidden by it" in rows[0].note


def test_an_undetermined_defect_of_a_known_size_hides_no_larger_failure():
    """Also next to a defect with a switch, whose names the rows have then."""
    late = KnownDefect(**{**ENTRY, "name": "late"}, undetermined="a step late", largest=1e4)
    near, far = (Code(factor=1.0 + size) for size in (1e-7, 1e-3))
    rows = rows_of(near, (late,))
    assert verdicts(rows) == ["not tested", "pass", "not tested", "pass"]
    assert "in this row up to 10000 tolerances is hidden by it" in rows[0].note
    assert verdicts(rows_of(far, (late,))) == ["fail", "pass", "fail", "pass"]
    both, more = (Code(TSUJI_FAULT, factor=1.0 + size) for size in (1e-7, 1e-3))
    rows = rows_of(both, (late, WEAK))
    assert verdicts(rows) == ["not tested"] * 3 + ["pass"]
    assert {row.defect for row in rows[:3]} == {"late, weak"}
    assert verdicts(rows_of(more, (late, WEAK))) == ["fail"] * 3 + ["pass"]


def test_a_run_that_dies_with_the_message_of_a_defect():
    dies = KnownDefect(**ENTRY, error="Lost atoms")
    lost = Code(error=EngineCrashError("ERROR: Lost atoms: 1").with_log("log"))
    rows = rows_of(lost, (dies,))
    assert verdicts(rows) == ["known defect"] * 3 + ["pass"]
    assert rows[0].log == "log"
    assert verdicts(rows_of(Code(error=EngineCrashError("SIGSEGV")), (dies,)))[0] == "fail"


@pytest.mark.parametrize("effect", [{"error": "NaN"}, {"undetermined": "nothing is known"}])
def test_an_error_of_the_harness_is_no_defect_of_the_engine(effect):
    checks = checks_of(TSUJI, "hertz, tsuji, wall")
    checks[0] = replace(checks[0], measure=lambda _: int(np.nan))  # "cannot convert float NaN"
    defects = (KnownDefect(**ENTRY, **effect),)
    rows = run_checks("head-on", checks, Bench(Code(TSUJI_FAULT)), version="2023", defects=defects)
    assert rows[0].failure is Failure.HARNESS
    assert not any(row.defect for row in rows)


def test_a_failure_names_the_convention_under_which_it_would_pass():
    rows = rows_of(Code(rules=Rules(wall_lever="height")), scene=SLIDING, setup="hooke, wall")
    failing = [row for row in rows if row.verdict is Verdict.FAIL and row.kind is Kind.CROSS_CODE]
    assert failing
    assert all("passes under wall_lever = height" in row.note for row in failing)


def test_rows_without_a_scene_have_errors_and_undetermined_defects_alone():
    open_ = KnownDefect(**ENTRY, undetermined="no reference has this")
    check = Check(setup="hertz, bulk", quantity="q", unit="1", measure=lambda _: 1.0, expected=2.0,
                  tolerance=NARROW)  # fmt: skip

    def verdict(*defects):
        (row,) = run_checks("silo", [check], Bench(Code()), version="2023", defects=defects)
        return row.verdict

    assert verdict(WEAK) is Verdict.FAIL
    assert verdict(open_) is Verdict.NOT_TESTED


def test_jobs_of_templates_of_one_name_in_two_packages_are_two_runs():
    jobs = [Job(Template("drop", {"": {}}, package=name), {"height": 1.0}) for name in ("a", "b")]
    assert job_key(jobs[0]) != job_key(jobs[1])
