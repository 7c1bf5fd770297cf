"""The search for a critical angle, on the energy map of the theory, and in engines."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.cases.bench import Bench
from harness.cases.incline import search
from harness.cases.incline.angle import extrapolate
from harness.cases.incline.case import CASE
from harness.cases.incline.closed_form import rigid_angle
from harness.cases.incline.runs import Fate, Run
from harness.cases.incline.search import (
    Ladder,
    angle_on,
    by_passage,
    by_steady_motion,
    critical_angle,
    extrapolated_critical_angle,
    prepared,
)
from harness.cases.incline.system import Incline
from harness.engines.base import Output
from harness.engines.output import Provenance
from harness.engines.reference import Reference
from harness.engines.registry import open_engine
from harness.errors import EngineCrashError, EngineOutputError, RequestError, Unsupported
from harness.model.law import PLASTIC, SOURCE, Contact
from harness.solvers.hard_sphere import critical_angle as by_events
from harness.theory.incline import critical_angle as closed_form
from harness.theory.incline import passage_margin
from tests.engine_doubles import Crashing, Twin

COARSE, SOFT = Incline(steps_per_contact=10.0), Incline(stiffness=1e5)
MOVES, TRAPPED = Fate.MOVES_ON, Fate.TRAPPED
METHODS = ("passage", "steady")


MAP = Output((), Provenance("map", "1"))


class EnergyMap:
    """Measures cases by the energy map of the theory, with jitter, or by a fate of the angle."""

    def __init__(self, shock=0.25, shift=None, fate=None, margin=None, touching=True):
        self.shock, self.shift, self.fate = shock, shift or (lambda _: 0.0), fate
        self.margin, self.touching, self.cases = margin, touching, []

    def __call__(self, cases):
        self.cases += cases
        return [self._run(case) for case in cases]

    def _run(self, case):
        angle = case.angle + self.shift(case)
        left = self.margin(angle) if self.margin else passage_margin(angle, self.shock)
        fate = Fate.MOVES_ON if left >= 0.0 else Fate.TRAPPED
        fate = self.fate(case.angle) if self.fate else fate
        return Run(case, fate, left, self.touching, 1.0, 10, np.empty(0), MAP)


def sawtooth(height_deg, at=0.0):
    """Return a shift [deg] that jumps once a step as the start moves through it."""
    return lambda case: height_deg * ((case.phase + at + 37.3 * case.angle) % 1.0 - 0.5)


def bands(*changes, first=TRAPPED, other=MOVES):
    """Return a fate that changes at each of some angles."""
    return lambda angle: (first, other)[sum(angle >= change for change in changes) % 2]


# ---- by passage


@given(st.floats(0.1, 0.5))
def test_the_root_of_the_map_is_the_closed_form(shock):
    found = by_passage(EnergyMap(shock), Incline())
    assert found.value == pytest.approx(closed_form(shock), abs=1e-4)
    assert found.method == "passage"


@given(st.floats(1e-5, 0.02), st.floats(0.0, 1.0))
def test_the_uncertainty_contains_the_truth_under_jitter(height, at):
    measure = EnergyMap(shift=sawtooth(height, at))
    found = by_passage(measure, Incline(), tolerance_deg=max(1e-3, height))
    error = abs(found.value - closed_form())
    assert error <= found.uncertainty + 1e-6
    assert error <= 1.01 * found.mean_error + 1e-6  # by a slope that is a little off
    assert found.uncertainty <= height


@given(st.floats(0.1, 0.5), st.floats(1e-6, 0.1))
def test_a_reference_leads_to_the_root_only_where_its_margin_is_the_measured_one(shock, off_deg):
    alone, guided = (EnergyMap(shock, shift=sawtooth(1e-3)) for _ in range(2))
    expected = by_passage(alone, Incline())
    for shift in (sawtooth(1e-3), lambda _: off_deg):
        reference = EnergyMap(shock, shift=shift)
        found = by_passage(guided, Incline(), guide=reference)
        assert (found.value, found.uncertainty) == (expected.value, expected.uncertainty)


def test_an_engine_searches_alone_where_the_reference_fails(monkeypatch):
    def fails(cases):
        raise EngineOutputError(f"no margin in {len(cases)} cases")

    with Reference() as engine:
        expected = angle_on(Bench(engine), Incline())
        monkeypatch.setattr(search, "reference_measure", lambda *_: fails)
        found = angle_on(Bench(engine), Incline())
    assert found.value == pytest.approx(expected.value, abs=1e-9)
    assert len(found.runs) > len(expected.runs)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("slope", [1e-3, 0.0])
def test_no_root_is_an_error(sign, slope):
    measure = EnergyMap(margin=lambda angle: sign + slope * angle)
    with pytest.raises(EngineOutputError, match=r"no critical angle between 0 and 30|no root"):
        by_passage(measure, Incline())


def test_a_margin_that_jumps_is_bracketed_where_a_secant_runs_off():
    jumps = EnergyMap(shift=lambda case: 0.03 * (1.0 - 2.0 * (20.0 * case.angle % 1.0)))
    found = by_passage(jumps, Incline())
    assert found.value == pytest.approx(closed_form(), abs=0.05)
    assert len(found.runs) > 12 + 8


def test_a_grain_in_flight_is_refused_with_the_other_method_named():
    with pytest.raises(RequestError, match=r"=passage needs .* in flight .*use method=steady"):
        by_passage(EnergyMap(touching=False), Incline())


# ---- by steady motion


@given(st.floats(0.05, 29.95))
def test_any_angle_is_found_from_the_usual_window_and_of_a_stiff_contact_in_few_runs(truth):
    few = 11 if 9.8 < truth < 10.8 else 25
    for case, most in ((SOFT, 60), (Incline(), few)):
        measure = EnergyMap(fate=bands(truth))
        found = by_steady_motion(measure, case)
        assert abs(found.value - truth) <= found.uncertainty <= 5e-3
        assert (found.monotone, found.note) == (True, "")
        assert len(found.runs) <= most
        assert len(measure.cases) <= 60
        assert all(0.0 <= run.angle <= 30.0 for run in measure.cases)


def test_a_moving_band_below_a_trapped_one_widens_the_uncertainty():
    found = by_steady_motion(EnergyMap(fate=bands(10.05, 10.3, 10.5)), SOFT)
    assert found.value == pytest.approx(10.05, abs=5e-3)
    assert not found.monotone
    assert found.note.startswith("not monotone: trapped again up to 10.")
    assert 10.5 <= found.value + found.uncertainty <= 10.51


def test_an_undecided_band_is_in_the_uncertainty_and_never_trapped():
    def fate(angle):
        return TRAPPED if angle < 10.15 else Fate.UNDECIDED if angle < 10.25 else MOVES

    measure = EnergyMap(fate=fate)
    found = by_steady_motion(measure, SOFT)
    assert found.value - found.uncertainty <= 10.15
    assert 10.25 <= found.value + found.uncertainty < 10.45
    assert "undecided within the time limit" in found.note
    assert len(measure.cases) <= 30


@pytest.mark.parametrize(
    ("fate", "words"),
    [
        (lambda _: MOVES, "no angle from 0 to 30 deg was trapped"),
        (lambda _: TRAPPED, "no angle from 0 to 30 deg kept moving"),
        (lambda _: Fate.UNDECIDED, "no angle from 0 to 30 deg was trapped"),
        (bands(10.2, first=MOVES, other=TRAPPED), "trapped|kept moving"),
    ],
)
def test_fates_without_a_rise_are_an_error(fate, words):
    with pytest.raises(EngineOutputError, match=words):
        by_steady_motion(EnergyMap(fate=fate), SOFT)


def test_probes_at_coarse_steps_find_bands_that_the_scan_missed():
    fate = bands(10.152, 10.154, 10.159, 10.161, 10.165)
    assert by_steady_motion(EnergyMap(fate=fate), SOFT, 1e-3).monotone
    measure = EnergyMap(fate=fate)
    found = by_steady_motion(measure, COARSE, 1e-3)
    assert not found.monotone
    assert found.value == pytest.approx(10.152, abs=5e-4)
    assert 10.165 <= found.value + found.uncertainty <= 10.166
    assert len(measure.cases) <= 100


def test_wells_to_pass_grow_with_coarse_steps_with_what_a_shock_leaves_and_with_a_slow_spin():
    assert prepared(Incline(), "steady").wells == 10
    assert prepared(COARSE, "steady").wells == 100
    assert prepared(COARSE, "steady", 7).wells == 7
    assert prepared(Incline(grain_diameter=2.0), "steady").wells == 28  # 0.605^28 = 4^-10
    slight, strong = (
        prepared(Incline(contact=PLASTIC, steps_per_contact=100.0, friction=mu), "steady").wells
        for mu in (0.016, 1.0)
    )
    assert 100 < slight < 130
    assert 15 <= strong <= 18


# ---- extrapolation


def test_the_limit_of_a_known_ladder():
    def angle(k, n):
        case = Incline(contact=PLASTIC, stiffness=k, steps_per_contact=n)
        bias = -400.0 / k - 300.0 / k**1.5 - 0.1 / n
        return replace(by_passage(EnergyMap(), case, phases=2), value=10.2 + bias, mean_error=1e-6)

    found = extrapolate([angle(k, n) for k in (1e5, 3e5, 1e6, 1e7) for n in (50.0, 100.0, 200.0)])
    assert found.value == pytest.approx(10.2, abs=2e-5)
    assert list(found.at_stiffness) == [1e5, 3e5, 1e6, 1e7]
    assert len(found.to_frame()) == 12
    assert found.to_json()["stiffness_N_per_m"] is None
    assert found.plot().axes


# ---- in engines


@pytest.mark.parametrize(
    ("name", "tail", "value", "uncertainty", "runs"),
    [
        ("reference", "attractive", 10.205311688960, 0.000906024153, 11),
        ("reference", "clipped", 10.216761077694, 0.001244103007, 13),
        pytest.param("lammps", "attractive", 10.205311688960117, 0.0009060241534095681, 11,
                     marks=pytest.mark.live),
    ],
)  # fmt: skip
def test_values_of_version_1(name, tail, value, uncertainty, runs, request):
    if name == "lammps":
        request.getfixturevalue("lammps_here")
    case = Incline(contact=SOURCE.replace(tail=tail))
    with open_engine(name, workers=1) as engine:
        found = critical_angle(case, engine=engine)
    rounding = 0.0 if name == "lammps" else 1e-9
    assert found.value == pytest.approx(value, rel=0.0, abs=rounding)
    assert found.uncertainty == pytest.approx(uncertainty, abs=max(rounding, 1e-12))
    assert len(found.runs) == len(found.to_frame()) == runs
    assert found.to_json()["engine"] == name
    assert found.plot().axes
    assert "10.2" in repr(found)


def test_steady_motion_has_the_values_of_version_1():
    with Reference() as engine:
        steady = critical_angle(method="steady", engine=engine)
    assert (steady.value, steady.uncertainty) == (10.203125, pytest.approx(0.003125))
    assert steady.to_json()["wells"] == 10
    assert steady.plot().axes


def test_friction_by_both_methods():
    base = Incline(contact=PLASTIC, steps_per_contact=100.0, friction=0.5)
    with Reference() as engine:
        for case in (base.replace(shape="disc", friction=0.1), base):
            passage = critical_angle(case, engine=engine)
            expected, _ = rigid_angle(case)
            assert passage.value == pytest.approx(expected, abs=3e-3)
        assert passage.to_json()["friction"] == 0.5
        soft = base.replace(stiffness=1e5, steps_per_contact=50.0)
        found, steady = (critical_angle(soft, method=m, engine=engine) for m in METHODS)
        assert steady.value == pytest.approx(found.value, abs=steady.uncertainty + 1e-3)


def test_a_run_that_dies_and_a_short_ladder_are_errors():
    with Crashing() as engine, pytest.raises(EngineCrashError):
        critical_angle(engine=engine)
    with pytest.raises(RequestError, match="needs four different"):
        Ladder(factors=(1.0, 2.0, 3.0))
    with pytest.raises(RequestError, match="needs three different"):
        Ladder(steps_per_contact=(50.0,))


@pytest.mark.parametrize(
    ("option", "words"),
    [
        ({"wells": 3}, "--wells 3: goes with --method steady only"),
        ({"method": "both"}, "method = 'both': must be 'passage' or 'steady'"),
        ({"tolerance_deg": 0.0}, "tolerance_deg = 0.0: must be from 1e-9 to 1 deg"),
        ({"phases": 1}, "phases = 1: must be at least 2"),
    ],
)
def test_options_that_are_refused(option, words):
    with pytest.raises(RequestError, match=words):
        critical_angle(Incline(), **option)


@pytest.mark.parametrize("measure", [critical_angle, extrapolated_critical_angle])
def test_a_rebounding_contact_and_one_that_the_engine_lacks_are_refused_before_any_run(measure):
    class Counting(Twin):
        def run(self, jobs):  # noqa: ARG002
            raise AssertionError("it was run")

        def rules(self, scene):
            if not scene.law.clipped:
                raise Unsupported("never attracts")
            return super().rules(scene)

    case = Incline(contact=Contact(restitution=0.5, tail="clipped"))
    with pytest.raises(RequestError, match=r"use method=steady; at e = 0.\d* .* deg .* deg"):
        measure(case, engine=Counting())
    with pytest.raises(RequestError, match=r"engine '\w+' cannot run 'incline': never attracts"):
        measure(Incline(contact=SOURCE), engine=Counting())


def test_the_search_of_the_case():
    case = CASE.presets["plastic"].replace(stiffness=1e4)
    with Reference() as engine:
        bench = Bench(engine)
        found = CASE.search(["critical_angle_deg", "runs"], case, bench, starts=2)
        coarse = {"method": "steady", "tolerance": 0.1}
        steady = CASE.search(["critical_angle_deg"], case.replace(wells=3), bench, **coarse)
        with pytest.raises(RequestError, match="use method=steady"):
            CASE.search(["runs"], Incline(contact=Contact(restitution=0.5)), bench)
    assert set(found) == {"critical_angle_deg", "runs"}
    assert 0.0 < found["critical_angle_deg"].uncertainty < steady["critical_angle_deg"].uncertainty
    with pytest.raises(RequestError, match="method"):
        CASE.search_options(method="guess")


@pytest.mark.slow
@pytest.mark.parametrize("e", [0.1, 0.3])
def test_rigid_spheres_by_events_are_the_limit_of_rebounding_contacts(e):
    """The second route of both: neither reading of one shock is near."""
    ladder = Ladder(factors=(1.0, 10.0, 100.0, 1000.0), steps_per_contact=(100.0, 200.0, 400.0))
    with Reference() as engine:
        case = Incline(contact=Contact(restitution=e))
        limit = extrapolated_critical_angle(case, ladder=ladder, engine=engine)
    assert limit.value == pytest.approx(by_events(e), abs=0.01)
