"""Engines beside LAMMPS, with stand-ins: what each becomes in the rows and in the evidence."""

import json
import math
from dataclasses import replace

import pytest
from harness.workflows.verification import verify
from harness.workflows.verification.other_engines import Asked, asked_engines, engine_checks
from harness.workflows.verification.other_engines.extent import STATED

from harness.cases.incline.critical_angles import critical_angle
from harness.cases.incline.engine_angles import microseconds_per_step, same_rules
from harness.cases.incline.parameters import Incline
from harness.cases.incline.rules import Stated, contacts_of, reference_for
from harness.comparison.verdicts import Kind, Verdict
from harness.engines import registry
from harness.engines.reference.engine import Reference
from harness.errors import EngineCrashError, RequestError
from harness.parameters.contact import CLIPPED, PLASTIC
from harness.report.finite import finite
from harness.workflows.progress import silent
from tests import engine_doubles as doubles


@pytest.fixture(autouse=True, scope="module")
def registered():
    """Register the stand-ins beside the engines that there are."""
    with pytest.MonkeyPatch.context() as patch:
        for name, kind in doubles.ENGINES.items():
            where = f"{kind.__module__}:{kind.__name__}"
            patch.setitem(registry.ENGINES, name, where)
        yield


def compared(*names, named=(), everything=False, level="quick"):
    asked = Asked(names, frozenset(named), everything)
    return engine_checks(asked, level, registry.open_engine, silent)


@pytest.fixture(scope="module")
def found(registered):  # noqa: ARG001
    return compared("reference", *doubles.ENGINES, named=("missing", "crashing"))


def rows(found, engine):
    return [check for check in found.checks if check.name.startswith(f"{engine}: ")]


def row(found, *words):
    (only,) = [c for c in found.checks if all(word in c.name for word in words)]
    return only


def test_all_is_every_engine_and_a_name_brings_lammps_and_the_reference_with_it():
    assert asked_engines("all").engines == tuple(registry.ENGINES)
    assert asked_engines("all").named == frozenset()
    asked = asked_engines("twin, half")
    assert set(asked.engines) == {"lammps", "reference", "twin", "half"}
    assert asked.named == {"twin", "half"}
    assert asked_engines(["all", "twin"]) == Asked(
        tuple(registry.ENGINES), frozenset({"twin"}), True
    )
    assert asked_engines(()) == Asked()


@pytest.mark.parametrize("wanted", ["nobody", "twin,nobody", ["all", "nobody"]])
def test_a_name_that_is_not_known_is_refused_with_those_that_are(wanted):
    with pytest.raises(RequestError, match=r"--engines 'nobody' is not known: must be all, or"):
        asked_engines(wanted)


@pytest.mark.parametrize("wanted", ["", ", "])
def test_a_text_without_a_name_is_refused(wanted):
    with pytest.raises(RequestError, match=f"--engines '{wanted}': names no engine"):
        asked_engines(wanted)


def test_an_engine_that_holds_has_no_failed_row(found):
    for engine in ("reference", "twin", "clamped", "half", "newer"):
        assert Verdict.FAIL not in {check.verdict for check in rows(found, engine)}


def test_the_plastic_contact_is_judged_by_the_closed_form_and_the_source_s_is_a_finding(found):
    plastic = row(found, "twin: critical angle, plastic")
    assert (plastic.kind, plastic.verdict) == (Kind.ANALYTIC, Verdict.PASS)
    assert plastic.tolerance == 0.003
    assert "k = 1e+06 N/m, 100 steps" in plastic.name
    source = row(found, "twin: critical angle, source")
    assert source.verdict is Verdict.FINDING
    assert source.difference > 0.01


def test_the_same_code_is_on_the_curve_of_the_reference_dem_to_the_last_bit(found):
    for engine in ("twin", "clamped", "half"):
        (shown, *_) = [a for a in found.evidence.angles if a.engine == engine]
        assert shown.off_reference_deg == 0.0
    assert row(found, "half: critical angle against", "m_eff m/2").verdict is Verdict.PASS


def test_an_engine_in_another_scheme_than_it_declares_is_off_the_curve(monkeypatch):
    declared = replace(doubles.Twin.traits, integrator="mfix-euler")
    monkeypatch.setattr(doubles.Clamped, "traits", replace(declared, tails=("clipped",)))
    monkeypatch.setattr(doubles.Clamped, "__init__", lambda self: Reference.__init__(self))
    off = row(compared("clamped"), "clamped: critical angle against", "source, clipped")
    assert off.verdict is Verdict.FAIL
    assert not off.engine_died


def test_what_an_engine_cannot_state_is_not_tested_with_the_reason(found):
    refused = row(found, "half: critical angle, plastic")
    assert refused.verdict is Verdict.NOT_TESTED
    assert "attractive tail" in refused.note
    refused = row(found, "clamped: critical angle, source contact")
    assert "clipped tail" in refused.note
    assert row(found, "clamped: critical angle, source, clipped").verdict is Verdict.FINDING


def test_lineage_is_said_in_the_rows_and_in_the_evidence(found):
    for check in (
        row(found, "twin: critical angle, plastic"),
        row(found, "twin: critical angle against", "plastic"),
    ):
        assert "regression partner, not independent evidence" in check.note
    assert {a.evidence for a in found.evidence.angles if a.engine == "twin"} == {
        "regression partner"
    }
    assert {a.evidence for a in found.evidence.angles if a.engine == "half"} == {"independent"}


def test_a_missing_engine_is_not_tested_and_says_how_to_get_it(found):
    missing = rows(found, "missing")
    assert len(missing) == 4
    assert {check.verdict for check in missing} == {Verdict.NOT_TESTED}
    assert all("apt install it" in check.note for check in missing)
    assert not any(check.engine_died for check in missing)


def test_only_named_engines_that_are_missing_or_die_are_errors(found):
    assert {error.partition(":")[0] for error in found.errors} == {"missing", "crashing"}
    assert compared("missing", "crashing", everything=True).errors == []


def test_a_dying_engine_leaves_failed_rows_with_its_log(found):
    died = [check for check in rows(found, "crashing") if check.engine_died]
    assert {check.log for check in died} == {"input\nlast words\n"}
    assert all(check.note == "crashed: signal SIGSEGV" for check in died)
    assert all(check.triage == "engine error: crashed" for check in died)
    names = " ".join(check.name for check in died)
    assert "plastic" in names
    assert "source" in names
    assert "order" in names
    untested = row(found, "crashing: critical angle against", "plastic")
    assert untested.verdict is Verdict.NOT_TESTED


def test_an_engine_that_fails_qualification_is_not_believed(found):
    failed = [c.name for c in rows(found, "undamped") if c.verdict is Verdict.FAIL]
    assert "undamped: restitution head-on, plastic" in failed
    assert not any(a.engine == "undamped" for a in found.evidence.angles + found.evidence.towers)
    for part in ("critical angle, plastic", "critical angle, source", "towers"):
        untested = row(found, f"undamped: {part}")
        assert untested.verdict is Verdict.NOT_TESTED
        assert "did not qualify: " in untested.note
        assert "restitution head-on, plastic" in untested.note
    (declared,) = [d for d in found.evidence.declared if d.engine == "undamped"]
    assert declared.standing == "did not qualify"


def test_another_version_is_a_finding_that_names_those_that_were_tried(found):
    other = row(found, "newer: version")
    assert other.verdict is Verdict.FINDING
    assert "0.0.1" in other.note
    assert not [c for c in found.checks if c.name == "twin: version"]


def test_an_engine_that_cannot_say_who_it_is_failed(monkeypatch):
    def broken(_):
        raise EngineCrashError("no answer")

    monkeypatch.setattr(doubles.Twin, "identify", broken)
    found = compared("twin", "clamped", everything=True)
    assert row(found, "twin: identification").verdict is Verdict.FAIL
    assert not found.errors


def test_unclamped_engines_of_one_class_agree_and_classes_are_findings(monkeypatch):
    monkeypatch.setattr(doubles.Newer, "name", "lammps")
    monkeypatch.setattr(doubles.Newer, "traits", doubles.TRAITS)
    monkeypatch.setitem(registry.ENGINES, "lammps", "tests.engine_doubles:Newer")
    found = compared("lammps", "twin", "clamped", "half")
    agree = row(found, "engines: twin against lammps")
    assert (agree.kind, agree.tolerance, agree.verdict) == (Kind.CROSS_CODE, 0.002, Verdict.PASS)
    assert "regression partner" in agree.note
    apart = row(found, "engines: clamped, source, clipped contact, less lammps")
    assert apart.verdict is Verdict.FINDING
    assert apart.expected == pytest.approx(apart.value, abs=1e-9)
    assert apart.value < -0.01
    row(found, "engines: half, source, m_eff m/2 contact, less lammps")


@pytest.mark.parametrize("everything", [True, False])
def test_recorded_mfix_stands_in_where_mfix_is_asked_for_and_not_here(everything):
    found = compared("twin", named=() if everything else ("twin",), everything=everything)
    recorded = [check for check in found.checks if check.name.startswith("mfix (recorded)")]
    assert bool(recorded) is everything
    assert {check.verdict for check in recorded} <= {Verdict.PASS}
    if everything:
        assert {a.evidence for a in found.evidence.angles if a.recorded} == {"recorded"}
        heights = [tower.height for tower in found.evidence.towers if tower.recorded]
        assert heights == [1, 2, 4, 9]


def test_a_live_mfix_takes_the_place_of_what_was_recorded(monkeypatch):
    monkeypatch.setattr(doubles.Half, "name", "mfix")
    monkeypatch.setitem(registry.ENGINES, "mfix", "tests.engine_doubles:Half")
    found = compared("mfix", named=("mfix",))
    assert not any(angle.recorded for angle in found.evidence.angles)


def test_an_engine_that_is_open_already_is_used_and_left_open():
    class Open(doubles.Twin):
        closed = False

        def close(self):
            self.closed = True

    engine = Open()
    asked = Asked(("twin",))

    def refuse(_):
        raise AssertionError("it is open already")

    engine_checks(asked, "quick", refuse, silent, engine)
    assert not engine.closed


def test_progress_is_told_engine_by_engine():
    told = []
    asked = Asked(("twin", "undamped"))
    engine_checks(asked, "quick", registry.open_engine, lambda *a: told.append(a))
    for stage in ("engine twin", "engine undamped"):
        steps = [(done, total) for name, done, total in told if name == stage]
        assert steps[0] == (0, 3)
        assert steps[-1] == (3, 3)


def test_what_a_step_costs_leaves_out_what_a_run_costs():
    class Slow(doubles.Twin):
        def inclines(self, cases, route, **options):
            runs = super().inclines(cases, route, **options)
            return [replace(run, seconds=2.0 + 5e-6 * run.steps) for run in runs]

    case = Incline(contact=PLASTIC, stiffness=1e5, steps_per_contact=50.0)
    angle = critical_angle(case, engine=Slow(), phases=1)
    assert microseconds_per_step(angle, Slow()) == pytest.approx(5.0)
    assert math.isnan(microseconds_per_step(angle, doubles.Crashing()))


def test_the_evidence_is_json(found):
    record = json.loads(json.dumps(finite(found.evidence.record())))
    assert {d["engine"] for d in record["declared"]} == {"reference", *doubles.ENGINES}
    assert all(isinstance(a["critical_angle_deg"], float) for a in record["critical_angles"])


def test_contacts_are_stated_in_the_effective_mass_of_the_engine():
    half = [c.contact for c in contacts_of(doubles.Half.traits) if isinstance(c, Stated)]
    assert [(c.name, c.effective_mass) for c in half] == [("source, m_eff m/2", "half")]
    full = [c.contact for c in contacts_of(doubles.Twin.traits) if isinstance(c, Stated)]
    assert [c.name for c in full] == ["plastic", "source"]
    clamped = [c.contact.name for c in contacts_of(doubles.Clamped.traits)]
    assert clamped == ["plastic", "source", "source, clipped"]


def test_the_reference_dem_follows_the_scheme_and_there_is_none_for_one_without():
    assert reference_for(doubles.Half.traits).integrator == "mfix-euler"
    assert reference_for(replace(doubles.TRAITS, integrator="")) is None
    found_none = replace(doubles.TRAITS, integrator="", tails=("clipped",))

    class Own(doubles.Twin):
        traits = found_none

        def __init__(self):
            Reference.__init__(self)

    asked = Asked(("own",))
    registry.ENGINES["own"] = "tests.engine_doubles:Twin"
    try:
        found = engine_checks(asked, "quick", lambda _: Own(), silent)
    finally:
        del registry.ENGINES["own"]
    assert row(found, "critical angle against", "plastic").verdict is Verdict.NOT_TESTED
    assert all(math.isnan(a.reference_deg) for a in found.evidence.angles)


@pytest.mark.parametrize(("digits", "least"), [(15, 5e-4), (6, 1.5e-3)])
def test_the_tolerance_beside_the_reference_grows_with_missing_digits(digits, least):
    stiffness, steps = STATED
    case = Incline(contact=CLIPPED, stiffness=stiffness, steps_per_contact=steps)
    with Reference() as engine:
        own = critical_angle(case, engine=engine, phases=2)
    width = same_rules(replace(doubles.TRAITS, digits=digits), own, 10.2078).width(0.0)
    assert least <= width < 2 * least


@pytest.mark.live
@pytest.mark.slow
def test_verify_with_engines_has_their_rows_and_its_status_counts_named_ones(monkeypatch):
    for name in set(registry.ENGINES) - {"lammps", "reference", *doubles.ENGINES}:
        monkeypatch.delitem(registry.ENGINES, name)
    found = verify("quick", engines="twin,missing", compare=False)
    assert found.status == 3
    assert found.engine_errors == ("missing: missing: no library of that name; to get it: "
                                   "apt install it",)  # fmt: skip
    assert {d.engine for d in found.engines.declared} == {"lammps", "reference", "twin", "missing"}
    everything = verify("quick", engines="all", compare=False)
    assert everything.engine_errors == ()
    assert everything.status == 1
