"""Contact cases in LAMMPS: limits that hold, defects that are found, releases that lack a model."""

import math
import subprocess
from pathlib import Path

import pytest

import harness
from harness.cases import oblique
from harness.cases.contact import invariance
from harness.cases.contact.submodels import TURNING
from harness.cases.contact.verification import verify_trials
from harness.cases.registry import get_case
from harness.cases.verification import Study
from harness.comparison.known_defects import mark_known_defects
from harness.comparison.verdicts import Kind, Verdict
from harness.engines.lammps.engine import Lammps
from harness.observables.provenance import Provenance, release_of
from harness.store.baseline import known_defects
from harness.workflows.case_runs import run

MENDED = {
    "wall-youngs-modulus",
    "wall-shear-modulus",
    "jkr-without-history",
    "dmt-limit-without-pull-off",
    "old-wall-hooke-coefficients",
    "wall-tsuji-again",
    "wall-touched-at-no-overlap",
    "rolling-uninitialised-in-setup",
    "mixed-material-is-hooke",
}
"""Defects of releases from 23 Jun 2022 to 29 Aug 2024 that later ones do not have."""

LONG = ("jkr-region-without-neck", "mdr-adhesion-fades")
"""Defects whose scripts take seconds."""

DEFECTS = [
    pytest.param(
        script,
        id=script.parent.name,
        marks=[pytest.mark.slow] if script.parent.name in LONG else [],
    )
    for script in sorted(
        (Path(harness.__file__).parent.parent / "reports" / "defects").glob("*/in.lmp")
    )
]

pytestmark = [pytest.mark.live, pytest.mark.usefixtures("lammps_here")]


@pytest.fixture(scope="module")
def lammps():
    with Lammps(workers=1) as engine:
        yield engine


def parted(checks):
    """Return the checks of limits, and those of what must not change a run."""
    invariances = [check for check in checks if check.kind is Kind.INVARIANCE]
    return [check for check in checks if check.kind is not Kind.INVARIANCE], invariances


def few(case, names, systems=("wall",)):
    """Return a case with some of its submodels."""
    found = type(case)()
    found.submodels = [one for one in case.submodels if one.name in names]
    found.systems = {name: case.systems[name] for name in systems}
    return found


@pytest.mark.parametrize(
    ("name", "submodels"),
    [
        ("head-on", ("hooke, velocity", "hertz, viscoelastic", "jkr")),
        ("oblique", ("linear_history", "mindlin_rescale/force")),
        ("spin", ("linear_nohistory", "mindlin")),
    ],
)
def test_the_limit_of_a_small_step_is_the_law(lammps, name, submodels):
    case = few(get_case(name), submodels, ("wall", "unequal spheres"))
    found = case.verification.run(lammps, Study("quick"))
    # the quick level takes the wall only
    limits, invariances = parted(found.checks)
    assert {c.cell.submodel for c in limits} == set(submodels)
    assert [c.verdict for c in limits if c.verdict is not Verdict.PASS] == []
    version = {"lammps": lammps.identify().engine_version}
    told = mark_known_defects(invariances, known_defects(), version)
    assert [c.name for c in told if c.verdict is Verdict.FAIL] == []
    for check in limits:
        assert check.tolerance <= max(1e-4, 1e-6 * abs(check.expected))
        assert check.cell.order_low <= check.cell.order <= check.cell.order_high
    assert len(found.records) == len(submodels)


def test_defects_are_found_by_name_in_the_release_that_has_them(lammps):
    version = lammps.identify().engine_version
    if not release_of("28 Mar 2023") <= release_of(version) <= release_of("22 Jul 2025 - Update 9"):
        pytest.skip(f"LAMMPS {version} may not have them")
    found = [
        *few(get_case("head-on"), ("old hooke, no damping", "hertz, tsuji"))
        .verification.run(lammps, Study("quick"))
        .checks,
        *few(get_case("oblique"), ("old hooke/history", "mindlin_classic", "linear_history"))
        .verification.run(lammps, Study("quick"))
        .checks,
    ]
    told = mark_known_defects(found, known_defects(), {"lammps": version})
    limits, invariances = (
        {c.note.partition(":")[0] for c in some if c.verdict is Verdict.KNOWN_DEFECT}
        for some in parted(told)
    )
    assert invariances >= {"documented limitation setup-with-full-step-velocity"}
    assert limits == {
        "known defect old-wall-without-damping",
        "known defect tsuji-restitution",
        "known defect old-wall-friction",
        "known defect classic-cap-without-radius",
    }
    assert not [c for c in told if c.verdict is Verdict.FAIL]
    assert {c.cell.submodel for c in told if c.verdict is Verdict.PASS} >= {"linear_history"}


def test_a_run_of_a_preset_gives_quantities_beside_their_references(lammps):
    settings = {"preset": "chung-ooi-4", "angle": "80"}
    found = run("oblique", settings, lammps).to_json()["quantities"]
    # sliding throughout: Coulomb's law alone
    assert found["tangential_impulse_ratio"]["value"] == pytest.approx(0.092, abs=1e-4)
    assert found["normal_restitution"]["reference"] == pytest.approx(0.98, abs=1e-6)
    assert all(abs(one["difference"]) < 2e-3 for one in found.values())
    elastic = run("head-on", {"preset": "chung-ooi-1"}, lammps).to_json()["quantities"]
    for name, published in (
        ("largest_force_N", 10.697e3),
        ("largest_overlap_m", 274.1e-6),
        ("contact_time_s", 40.34e-6),
    ):
        assert elastic[name]["value"] == pytest.approx(published, rel=2e-4)


def test_a_release_without_a_submodel_says_which_one_has_it(lammps, monkeypatch):
    case = get_case("oblique")
    job = case.job(case.default.replace(damping="coeff_restitution", restitution=0.9))
    assert lammps.refuses(job) == ""
    old = Provenance("lammps", "2 Aug 2023 - Update 3")
    monkeypatch.setattr(lammps, "identify", lambda: old)
    assert lammps.refuses(job) == (
        "LAMMPS 2 Aug 2023 - Update 3 has no coeff_restitution: LAMMPS 29 Aug 2024 has it"
    )


def test_heat_is_refused_by_releases_without_its_submodels_alone(lammps, monkeypatch):
    case = get_case("heat")
    job = case.job(case.default)
    monkeypatch.setattr(lammps, "identify", lambda: Provenance("lammps", "2 Aug 2023"))
    assert lammps.refuses(job) == ""
    monkeypatch.setattr(lammps, "identify", lambda: Provenance("lammps", "23 Jun 2022 - Update 4"))
    assert lammps.refuses(job) == (
        "LAMMPS 23 Jun 2022 - Update 4 has no heat radius: LAMMPS 2 Aug 2023 has it"
    )


def test_a_release_with_wrong_walls_is_not_tested_where_the_sphere_would_not_rest(
    lammps, monkeypatch
):
    case = get_case("moving-wall")
    trials = [t for t in case.trials("full") if t.system == "along"]
    monkeypatch.setattr(lammps, "identify", lambda: Provenance("lammps", "23 Jun 2022 - Update 4"))
    refused = {t.submodel: lammps.refuses(case.job(t.parameters)) for t in trials}
    assert refused == {
        "mindlin": "LAMMPS 23 Jun 2022 - Update 4 has wrong moduli at walls, on which the sphere "
        "would not start at rest",
        "linear_history": "",
    }
    monkeypatch.setattr(lammps, "identify", lambda: Provenance("lammps", "2 Aug 2023"))
    assert not any(lammps.refuses(case.job(t.parameters)) for t in trials)


@pytest.mark.parametrize("system", ["wall", "two spheres"])
def test_mdr_holds_in_every_system_and_is_magnified_at_a_wall(lammps, system):
    case = few(get_case("head-on"), ("mdr", "mdr, velocity"), (system,))
    limits, invariances = parted(case.verification.run(lammps, Study("quick")).checks)
    judged = [check for check in limits if check.cell]
    assert {(c.cell.submodel, c.cell.system) for c in judged} == {
        ("mdr", system), ("mdr, velocity", system)
    }  # fmt: skip
    assert {check.verdict for check in judged} == {Verdict.PASS}
    told = [check.note for check in limits if not check.cell]
    assert bool(told) == (system == "wall")
    assert all("wall_force = magnified" in note for note in told)
    broken = mark_known_defects(
        invariances, known_defects(), {"lammps": lammps.identify().engine_version}
    )
    assert Verdict.FAIL not in {check.verdict for check in broken}


@pytest.mark.parametrize(
    ("name", "submodels"),
    [
        ("head-on", ("mdr, yield", "mdr, bulk")),
        ("oblique", ("mdr, mindlin", "mdr, yield, mindlin", "mdr, bulk, mindlin")),
    ],
)
def test_what_mdr_yields_its_bulk_and_friction_beside_it_hold(lammps, name, submodels):
    case = few(get_case(name), submodels, ("wall", "two spheres"))
    trials = case.trials("default", case.submodels)
    judged = [
        one for one in verify_trials(case, lammps, Study("default"), trials).checks if one.cell
    ]
    assert {(c.cell.submodel, c.cell.system) for c in judged} == {
        (submodel, system) for submodel in submodels for system in case.systems
    }
    assert {check.verdict for check in judged} == {Verdict.PASS}


def test_a_radius_that_grows_is_a_step_late_on_another_rank_which_is_known(lammps, monkeypatch):
    # four on fewer cores wait for one another: level full of the slow tests has them
    monkeypatch.setattr(invariance, "_most_ranks", lambda *_: 2)
    case = few(get_case("head-on"), ("mdr, yield",), ("two spheres",))
    checks = [check for check in invariance.invariances(case, lammps, Study("full")) if check.cell]
    versions = {"lammps": lammps.identify().engine_version}
    told = mark_known_defects(checks, known_defects(), versions)
    found = {check.cell.invariance: check for check in told}
    assert found["continued with a setup"].verdict is Verdict.PASS
    if found["2 ranks"].verdict is Verdict.NOT_TESTED:
        pytest.skip(found["2 ranks"].note)
    assert found["2 ranks"].verdict is Verdict.KNOWN_DEFECT
    assert "mdr-radius-late-on-ghosts" in found["2 ranks"].note
    # 3e-5 and more where scripts have atom_style sphere 0, which leaves ghosts their first radius
    assert found["2 ranks"].value < 1e-5


def test_the_adhesion_of_mdr_fades_with_the_step_which_is_known(lammps):
    case = few(get_case("pull-off"), ("mdr, adhesion",), ("two spheres",))
    checks = verify_trials(case, lammps, Study("default"), case.trials("default")).checks
    assert {check.verdict for check in checks} == {Verdict.FAIL}
    versions = {"lammps": lammps.identify().engine_version}
    told = mark_known_defects(checks, known_defects(), versions)
    assert {check.verdict for check in told} == {Verdict.KNOWN_DEFECT}
    assert all("mdr-adhesion-fades" in check.note for check in told)


def test_the_dashpots_of_mdr_are_those_of_wall_and_pair_interchanged_which_is_known(lammps):
    case = few(get_case("head-on"), ("mdr, mdr damping",), ("wall", "two spheres"))
    trials = case.trials("default", case.submodels)
    checks = verify_trials(case, lammps, Study("default"), trials).checks
    checks = [check for check in checks if check.cell]
    versions = {"lammps": lammps.identify().engine_version}
    told = mark_known_defects(checks, known_defects(), versions)
    assert {check.verdict for check in told} == {Verdict.KNOWN_DEFECT}
    assert all("mdr-damping-interchanged" in check.note for check in told)
    # eta_0 of the restitution that is found, in the limit of Hertz's overlaps: twice, and half
    for check in told:
        if check.name.endswith("restitution"):
            logarithm = -math.log(check.value)
            zeta = logarithm / math.hypot(math.pi, logarithm)
            factor = 0.5 if check.cell.system == "wall" else 2.0
            assert zeta == pytest.approx(factor * 0.25 * math.sqrt(0.3), rel=0.01)


def marked(lammps, checks):
    """Return checks, with failures that known defects explain marked."""
    return mark_known_defects(checks, known_defects(), {"lammps": lammps.identify().engine_version})


@pytest.mark.parametrize(
    ("name", "submodels"),
    [
        ("prescribed-motion", ("mindlin, dmt", "mindlin, jkr")),
        ("prescribed-motion", tuple(one.name for one in TURNING)),
        ("head-on", ("old hooke, clipped", "old hertz/history, clipped")),
    ],
)
def test_they_hold_from_the_default_level_on(lammps, name, submodels):
    case = get_case(name)
    chosen = [one for one in case.submodels if one.name in submodels]
    assert not [*case.trials("quick", chosen)]
    trials = [t for t in case.trials("default", chosen) if t.system in ("wall", "two spheres")]
    checks = marked(lammps, verify_trials(case, lammps, Study("default"), trials).checks)
    assert {c.cell.submodel for c in checks if c.verdict is Verdict.PASS} == set(submodels)
    broken = {c.name for c in checks if c.verdict not in (Verdict.PASS, Verdict.FINDING)}
    # the torque at its limit, and in a pair that is tilted its part about other axes
    assert all("marshall" in name or "twisting sds, mindlin, jkr" in name for name in broken)
    assert not [name for name in broken if "_forth" in name and "marshall" not in name]
    assert not [c for c in checks if c.verdict is Verdict.FAIL]


def test_springs_of_rolling_turn_round_on_another_rank_which_is_known(lammps, monkeypatch):
    # four on fewer cores wait for one another: level full of the slow tests has them
    monkeypatch.setattr(invariance, "_most_ranks", lambda *_: 2)
    case = type(get_case("prescribed-motion"))()
    case.submodels = [one for one in TURNING if "marshall" not in one.name]
    case.systems = {"two spheres, turned": case.systems["two spheres, turned"]}
    checks = marked(lammps, invariance.invariances(case, lammps, Study("full")))
    ranks = [check for check in checks if check.cell and check.cell.invariance == "2 ranks"]
    assert len(ranks) == len(case.submodels)
    if ranks[0].verdict is Verdict.NOT_TESTED:
        pytest.skip(ranks[0].note)
    assert {check.verdict for check in ranks} == {Verdict.KNOWN_DEFECT}
    assert all("rolling-turned-round-on-exchange" in check.note for check in ranks)
    # torques that turn round, no round-off
    assert all(check.value > 0.01 for check in ranks)
    assert not [check for check in checks if check.verdict is Verdict.FAIL]


def test_a_bounce_off_a_frozen_sphere_stays_on_the_axis_and_holds_to_a_millionth(lammps):
    case, names = get_case("bounce"), ("hooke, velocity", "hertz, viscoelastic", "old hooke")
    chosen = [one for one in case.submodels if one.name in names]
    trials = [t for t in case.trials("default", chosen) if t.system == "frozen sphere"]
    found = verify_trials(case, lammps, Study("default"), trials)
    assert {check.cell.submodel for check in found.checks} == set(names)
    assert {check.verdict for check in found.checks} == {Verdict.PASS}
    assert all(check.tolerance <= 1e-6 for check in found.checks)
    for one in found.evidence.refined:
        assert not one.motion.position[:, 0, :2].any()


@pytest.mark.parametrize("script", DEFECTS)
def test_the_script_of_a_defect_runs_with_lammps_alone(script, tmp_path, lammps):
    try:
        program = lammps.twin().program
    except Exception as error:
        pytest.skip(f"no lmp: {error}")
    done = subprocess.run(
        [program, "-in", str(script), "-log", "none"],
        cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip
    told = next(line for line in done.stdout.splitlines() if ": expected" in line)
    words = told.replace(",", "").split()
    expected, found = (float(words[words.index(w) + 1]) for w in ("expected", "found"))
    assert (abs(found - expected) < 1e-3) == (script.parent.name in MENDED) or math.isnan(found)


def test_points_beside_partial_slip_lie_on_the_law_that_the_engine_states(lammps):
    found = oblique.measured_rebounds(oblique.CASE, lammps)
    assert found.law == "mindlin"
    expected = oblique.expected_rebounds(oblique.CASE, found.law)
    assert found.psi == pytest.approx(expected, abs=5e-3)
    figure = oblique.partial_slip_figure({found.law: expected}, {"LAMMPS": found})
    assert [len(line.get_xdata()) for line in figure.axes[0].get_lines()] == [121, 12, 12]
