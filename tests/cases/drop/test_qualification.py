"""An engine that breaks a rule it declares fails by the drop that is made for it."""

from dataclasses import replace

import numpy as np
import pytest

from harness.cases.drop.case import Drop, case_of, drop_tests, restitution, scene_of, values_of
from harness.cases.grain import COLUMNS
from harness.cases.qualification import qualify
from harness.cases.registry import get_case
from harness.comparison.verdicts import Verdict
from harness.engines.cost import in_words
from harness.engines.reference import INTEGRATORS, Reference
from harness.engines.registry import open_engine
from harness.errors import EngineCrashError, EngineTimeoutError
from harness.observables.reference import Trajectory
from harness.parameters.law import Contact
from harness.solvers.pair.integration import integrate
from tests.engine_doubles import Twin, frictionless, most_damping


class Trapped(Reference):
    """The reference DEM with a fault: a change of the case, or of the path that it returns."""

    name = "trapped"

    def __init__(self, case=lambda c: c, path=lambda _, p: p):
        super().__init__()
        self._change_case, self._change_path = case, path

    def run(self, jobs):
        cases = [case_of(job.values) for job in jobs]
        changed = [values_of(self._change_case(case)) for case in cases]
        outputs = self.run_scenes([scene_of(values) for values in changed])
        return [
            with_path(output, self._change_path(case, path_of(output)))
            for case, output in zip(cases, outputs, strict=True)
        ]


def path_of(output):
    return Trajectory(*(np.asarray(output.tables["series"][name]) for name in COLUMNS))


def with_path(output, path):
    return replace(output, tables={"series": dict(zip(COLUMNS, vars(path).values(), strict=True))})


def failed(engine):
    return {c.name.partition(": ")[2].partition(",")[0] for c in qualify(engine).checks if
            c.verdict is Verdict.FAIL}  # fmt: skip


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_the_reference_qualifies_with_every_integrator(integrator):
    found = qualify(Reference(integrator))
    assert found.holds, found.failures
    assert found.failures == ""


def test_engines_qualify_that_state_no_contact_with_friction():
    """A contact case would leave them without a qualification."""
    engine = Twin()
    assert not engine.traits.contact_models
    job = get_case("head-on").job(get_case("head-on").default)
    assert engine.refuses(job)
    assert qualify(engine).holds


@pytest.mark.live
def test_lammps_qualifies():
    with open_engine("lammps") as engine:
        found = qualify(engine)
    assert found.holds, found.failures
    assert len(found.checks) == 11


def test_an_engine_that_runs_out_of_time_is_told_to():
    class Slow(Reference):
        name = "slow"

        def run(self, jobs):
            return [EngineTimeoutError("slow 1 did not finish within 3 s") for _ in jobs]

    found = qualify(Slow())
    assert not found.holds
    assert found.reason.startswith("restitution head-on, ")
    told = " (out of time: slow 1 did not finish within 3 s, the first of 11 that ended so)"
    assert found.reason.endswith(told)


def undamped(case):
    return case.replace(contact=case.contact.replace(restitution=1.0, damping_ratio=None))


def half(case):
    mass = "half" if case.contact.effective_mass == "full" else "full"
    return case.replace(contact=case.contact.replace(effective_mass=mass))


def other_tail(case):
    tail = "clipped" if case.contact.tail == "attractive" else "attractive"
    return case.replace(contact=case.contact.replace(tail=tail))


def late(case, path):
    """Let the sphere be found 20 steps late: until then the grain flies on."""
    shifted = [
        np.r_[column[:1].repeat(20), column[:-20]] for column in (path.vx_m_per_s, path.vy_m_per_s)
    ]
    y = path.y_m.copy()
    y[1:] = y[0] + np.cumsum(shifted[1][1:]) * case.step * case.every
    return Trajectory(path.time_s, path.x_m, y, *shifted)


def dragged(case, path):
    """Damp the motion along the tangent, as a dashpot on the whole relative velocity does."""
    drag = np.exp(-path.time_s / case.contact_time)
    return Trajectory(path.time_s, path.x_m, path.y_m, path.vx_m_per_s * drag, path.vy_m_per_s)


def slow_clock(_, path):
    return Trajectory(2.0 * path.time_s, *list(vars(path).values())[1:])


@pytest.mark.parametrize(
    ("trap", "shown"),
    [
        ({"case": undamped}, "restitution head-on"),
        ({"case": half}, "restitution head-on"),
        ({"case": other_tail}, "restitution head-on"),
        ({"case": lambda c: c.replace(stiffness=2.0 * c.stiffness)}, "static contact"),
        ({"path": late}, "contact found within two steps"),
        ({"path": dragged}, "oblique contact"),
        ({"path": slow_clock}, "free fall over g t^2 / 2"),
    ],
    ids=["no dashpot", "m/2", "tail", "spring", "late contact", "drag", "clock"],
)
def test_each_trap_is_caught(trap, shown):
    assert shown in failed(Trapped(**trap))


def test_a_damping_that_is_declared_half_is_held_against_half():
    class Half(Trapped):
        traits = replace(
            Reference.traits,
            frictionless=most_damping(0.999, effective_mass="half"),
        )

    assert qualify(Half()).holds
    assert "restitution head-on" in failed(Half(case=half))


def test_what_cannot_be_stated_is_not_tested_and_says_why():
    class Clamped(Reference):
        traits = replace(Reference.traits, frictionless=frictionless(tail="clipped"))

    found = qualify(Clamped())
    (row,) = [c for c in found.checks if c.verdict is Verdict.NOT_TESTED]
    assert "source contact" in row.name
    assert "tail = clipped" in row.note
    assert found.holds


class Dying(Reference):
    """Dies in one run, or altogether; or lets the grain fly through the sphere."""

    def __init__(self, how):
        super().__init__()
        self._how = how

    def run(self, jobs):
        if self._how == "all":
            raise EngineCrashError("it fell over")
        outputs = super().run(jobs)
        if self._how == "one":
            return [EngineCrashError("it fell over"), *outputs[1:]]
        return [self._through(output) for output in outputs]

    def _through(self, output):
        path = path_of(output)
        still = [np.full_like(v, v[0]) for v in (path.vx_m_per_s, path.vy_m_per_s)]
        return with_path(output, Trajectory(path.time_s, path.x_m, path.y_m, *still))


@pytest.mark.parametrize(
    ("how", "words"), [("one", "fell over"), ("all", "fell over"), ("blind", "never felt")]
)
def test_an_engine_that_dies_is_reported_and_does_not_qualify(how, words):
    found = qualify(Dying(how))
    assert not found.holds
    assert any(words in check.note for check in found.checks)
    assert any(c.engine_died for c in found.checks)


def test_the_expectation_knows_the_rule():
    """e = 0.5 with m/2 in the dashpot is 0.616, clipped 0.550: physics.md, section 4."""
    by_name = {c.name: c.expected for c in qualify(Reference()).checks}
    full = Contact(restitution=0.5, damping_ratio=None)
    assert by_name["reference: restitution head-on, e = 0.5, attractive, m_eff full"] == (
        pytest.approx(0.5, rel=1e-12)
    )
    halved = full.replace(effective_mass="half").zeta_against_full_mass
    assert halved == pytest.approx(full.zeta / np.sqrt(2.0))


@pytest.mark.parametrize("mass", ["full", "half"])
@pytest.mark.parametrize("tail", ["attractive", "clipped"])
def test_the_solver_of_contacts_with_friction_integrates_the_same_scene(tail, mass):
    """One law: the contact without friction is hooke with a constant dashpot, clipped or not."""
    contact = Contact(restitution=0.5, tail=tail, effective_mass=mass)
    case = Drop(contact=contact, speed=1.0, gap=1e-3, every=100, duration=4.0)
    path = integrate(scene_of(values_of(case)))
    free = path.velocities[-1, 0]
    assert free[1] / case.speed == pytest.approx(restitution(case), abs=1e-9)
    assert (free[0], free[2]) == (0.0, 0.0)


class Clock:
    """Stands in for ``time``: a start takes 2 s, the first one 100 s more, a step so long."""

    def __init__(self, step):
        self.now, self.step, self.starts = 0.0, step, 0

    def monotonic(self):
        return self.now

    def change_output(self, job, output):
        self.now += 2.0 + 100.0 * (self.starts == 0) + self.step * job.values["steps"]
        self.starts += 1
        return output


@pytest.mark.parametrize(("step", "long"), [(1e-2, True), (1e-6, False)])
def test_a_long_qualification_is_announced_by_what_a_step_takes(monkeypatch, step, long):
    clock = Clock(step)
    monkeypatch.setattr("harness.cases.drop.case.time", clock)
    engine, told = Twin(change_output=clock.change_output), []
    engine.workers = 1
    monkeypatch.setattr(engine, "fingerprint", lambda: None)
    assert qualify(engine, tell=told.append).holds
    count = len(list(drop_tests(engine.traits)))
    steps = sum(job.values["steps"] for job in engine.jobs[-count:])
    probes = engine.jobs[:-count]
    assert len(probes) == 3
    assert sum(job.values["steps"] for job in probes) < 0.02 * steps
    expected = in_words(float(f"{step * steps:.2g}"))
    assert told == [f"twin: about {expected} for its qualification"] * long
