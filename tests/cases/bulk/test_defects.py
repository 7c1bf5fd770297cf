"""What defects do in bulk: switches change the defect alone, the table tells moved from equal."""

import csv
import math
import re
from dataclasses import replace
from pathlib import Path

import pytest
from scipy.integrate import solve_ivp

from harness.cases import silo
from harness.cases.bulk.defects import (
    LAW,
    NOT_RUN,
    PREDICTION,
    QUANTITIES,
    Runs,
    bare,
    drawn,
    read,
    runs_of,
    table,
    unswitched,
    updated,
    written,
)
from harness.cases.bulk.equivalence import FEWEST
from harness.cases.bulk.seeds import MARGIN
from harness.cases.bulk.switches import (
    HERTZ_WALLS,
    OLDER,
    OLDEST,
    UNSWITCHED,
    Switch,
    Variant,
    between_grains,
    dashpot,
    default,
    hertz,
    hertz_wall,
    linear,
    mindlin,
    mixed_shear_factor,
    number,
    pair_moduli,
    reduced,
    silo_walls,
    switches,
    tsuji_restitution,
    walled,
    without_restitution,
)
from harness.cases.penetration import COLUMNS
from harness.cases.registry import get_case
from harness.engines.registry import engine_class
from harness.errors import EngineError, EngineMissingError
from harness.solvers.pair.normal import TSUJI
from harness.store.baseline import known_defects

SWITCHES = list(switches())
REPORT = Path(__file__).parents[3] / "reports" / "bulk"
A, B = Variant({"damping": "a"}), Variant({"damping": "b"})
SWITCH = Switch("tsuji-restitution", "silo", "on", "off", A, B)


def table_of(values, seeds=8, switch=SWITCH):
    """Return the rows of runs whose values are given for each variant."""
    runs = {str(variant): numbers for variant, numbers in values}

    def run(_, variant, seeds):
        return Runs({"discharge_rate_per_s": tuple(runs[str(variant)][:seeds])})

    return list(table([switch], seeds, run))


SPREAD = [1.0, 1.02, 0.98, 1.01, 0.99, 1.0, 1.015, 0.985]


@pytest.mark.parametrize(
    ("factor", "spread", "verdict"),
    [
        (1.0, 1.0, "equivalent"),
        (1.1, 1.0, "moved"),
        (0.9, 1.0, "moved"),
        (1.05, 1.0, "undecided"),
        (1.0, 10.0, "undecided"),
    ],
)
def test_a_ratio_is_moved_equivalent_or_undecided(factor, spread, verdict):
    off = [1.0 + spread * (x - 1.0) for x in SPREAD]
    (row,) = table_of([(A, off), (B, [factor * x for x in off])])
    assert row.verdict == verdict
    assert row.low <= factor <= row.high
    assert row.ratio == pytest.approx(factor)


def test_runs_that_fail_leave_no_verdict():
    def run(_, variant, seeds):
        if variant == A:
            raise EngineMissingError("not here")
        return Runs({"discharge_rate_per_s": (1.0,) * seeds})

    (row,) = table([SWITCH], 8, run)
    assert (row.verdict, row.without_value) == ("not tested", "1 not found")
    assert math.isnan(row.ratio)
    (row,) = table_of([(A, SPREAD), (B, SPREAD)], seeds=3)
    assert (row.verdict, row.without_value) == ("not tested", "")


def test_a_variant_is_run_once_and_an_exact_prediction_not_at_all():
    asked = []

    def run(case, variant, _):
        asked.append((case, str(variant)))
        return Runs({q: tuple(SPREAD) for q in QUANTITIES[case]})

    rows = list(table(SWITCHES, 8, run))
    assert len(asked) == len(set(asked))
    exact = {(s.case, str(s.predicted)) for s in SWITCHES if s.exact}
    assert exact
    assert not exact & set(asked)
    assert {row.against for row in rows} == {LAW, PREDICTION}
    assert {row.verdict for row in rows} == {"equivalent"}


def test_a_failed_seed_has_no_value():
    class Dies:
        traits = engine_class("lammps").traits

        def __enter__(self):
            return self

        def __exit__(self, *_):
            pass

        def run(self, jobs):
            return [EngineError("died") for _ in jobs]

    runs = runs_of("drum", A, 3, lambda _: Dies())
    assert runs.values == {"mixing_index": (), "surface_angle_deg": ()}
    assert len(runs.failed) == 3


# ---- coefficients


@pytest.mark.parametrize("restitution", [0.2, 0.4, 0.5, 0.8])
def test_restitution_of_tsuji_is_that_of_the_dashpot_with_half_the_mass(restitution):
    alpha = sum(c * restitution**n for n, c in enumerate(TSUJI))

    def motion(_, state):
        overlap, speed = max(state[0], 0.0), state[1]
        # m* = k = 1; F = k x^1.5, eta = alpha sqrt(m* F/x)
        return speed, -(overlap**1.5) - alpha * overlap**0.25 * speed

    def parts(t, state):
        return state[0] if t > 0.1 else 1.0

    parts.terminal, parts.direction = True, -1
    end = solve_ivp(motion, (0.0, 50.0), (1e-12, 1.0), events=parts, rtol=1e-10, atol=1e-13)
    assert tsuji_restitution(restitution) == pytest.approx(-end.y[1, -1], rel=1e-5)


def test_tsuji_of_an_elastic_impact_is_elastic():
    assert tsuji_restitution(1.0) == pytest.approx(1.0, abs=1e-3)  # the fit has alpha(1) = 2e-4


@pytest.mark.parametrize("nu", [0.0, 0.2, 0.4])
def test_mixing_halves_the_tangential_stiffness(nu):
    assert mixed_shear_factor(1e6, 1e6, nu) == pytest.approx(0.5 / (1.0 - nu**2))
    assert mixed_shear_factor(1e6, 2e8, nu) == pytest.approx(0.5 / (1.0 - nu**2))


def test_linear_spring_and_dashpot():
    radius, overlap, small = 2e-3, 2e-5, 1e-9

    def force(x):
        return hertz(1e6, 0.2) * math.sqrt(radius) * x**1.5

    slope = (force(overlap + small) - force(overlap - small)) / (2.0 * small)
    assert linear(1e6, 0.2, radius) == pytest.approx(slope, rel=1e-6)
    k, m = 300.0, 1e-4
    zeta = dashpot(0.4, k, m) / (2.0 * math.sqrt(k / m))
    assert math.exp(-math.pi * zeta / math.sqrt(1.0 - zeta**2)) == pytest.approx(0.4)


def test_a_pair_is_stated_as_its_moduli():
    # Mindlin's 8 G* and Hertz's 4/3 E* of two equal bodies
    modulus, nu = 3e6, 0.3
    shear, normal = modulus / (2.0 * (1.0 + nu)), modulus / (2.0 * (1.0 - nu**2))
    assert mindlin(modulus, nu) == pytest.approx(8.0 * shear / (2.0 * (2.0 - nu)))
    assert hertz(modulus, nu) == pytest.approx(4.0 / 3.0 * normal)


def test_pairs_of_the_drum_have_the_modulus_of_both():
    drum = pair_moduli("drum")
    assert list(drum) == ["of_large", "of_small", "of_both"]
    assert 1.0 / drum["of_both"] == pytest.approx(0.5 / drum["of_large"] + 0.5 / drum["of_small"])
    grain = default("silo").grain
    assert reduced(grain, grain) == pytest.approx((0.5 * grain.radius, 0.5 * grain.mass))


# ---- scripts


def text_of(switch, variant):
    """Return the script of a variant, as LAMMPS gets it."""
    engine = engine_class("lammps")(lmp="true")
    engine.replaced = variant.replaced
    case = get_case(switch.case)
    job = case.job(default(switch.case))
    return engine.task(replace(job, values={**job.values, **variant.values}))


@pytest.mark.parametrize("switch", SWITCHES, ids=lambda s: f"{s.defect} {s.case} {s.words}")
def test_variants_differ_in_the_lines_that_they_name(switch):
    off, on = (text_of(switch, variant) for variant in (switch.off, switch.on))
    apart = [(v.release, v.ranks) for v in (switch.off, switch.on)]
    assert (off.script.text, off.values, apart[0]) != (on.script.text, on.values, apart[1])
    kept = [task.script.text.splitlines() for task in (off, on)]
    assert len(kept[0]) == len(kept[1])
    patterns = {*switch.off.replaced, *switch.on.replaced}
    changed = [a for a, b in zip(*kept, strict=True) if a != b]
    assert len(changed) <= len(patterns)


@pytest.mark.parametrize(("pattern", "times"), [("^no such line$", 0), ("^variable ", 80)])
def test_a_pattern_that_does_not_match_once_is_an_error(pattern, times):
    with pytest.raises(EngineError, match=r"silo.in: .* matches \d+ times: must match once") as e:
        text_of(SWITCH, Variant(replaced={pattern: ""}))
    found = int(re.search(r"matches (\d+)", str(e.value))[1])
    assert found == 0 if times == 0 else found > 1


def test_another_line_is_another_run():
    case = get_case("silo")
    engine = engine_class("lammps")(lmp="true")
    before = engine.script_digest(case.job(case.default))
    engine.replaced = {"^newton off$": "newton on"}
    assert engine.script_digest(case.job(case.default)) != before


# ---- LAMMPS: the defect alone


def energy(case, variant, steps=1600):
    """Return the kinetic energy [J] after some steps, ten digits; of the penetration with a sphere.

    It is released after 300 steps, and has touched the lattice 150 steps later.
    """
    if case == "penetration":
        return run_of(case, variant, 300, steps - 300).table(COLUMNS)["kinetic_J"][-1]
    return run_of(case, variant, steps, 50).number("bed_kinetic_J")


def run_of(case, variant, settle_steps, steps):
    """Return the output of a run that is short."""
    chosen = get_case(case)
    job = chosen.job(default(case))
    more = {"settle_steps": settle_steps, "steps": steps, "series_every": 50}
    with bare(variant) as engine:
        (output,) = engine.run([replace(job, values={**job.values, **variant.values, **more})])
    if isinstance(output, EngineError):
        raise output
    return output


ROUNDING = 1e-7
"""Relative: what the first contacts make of another order of sums, of ten digits that are read."""

ANOTHER = 1e-5
"""Relative: a hundred times as much is another law; the first contacts are few."""


@pytest.mark.slow
@pytest.mark.live
@pytest.mark.parametrize(
    "switch", [s for s in SWITCHES if s.exact], ids=lambda s: f"{s.defect} {s.case}"
)
def test_the_defect_is_the_law_that_its_cause_predicts(switch):
    need_release(switch.on.release)
    off, on, predicted = (
        energy(switch.case, variant) for variant in (switch.off, switch.on, switch.predicted)
    )
    assert on == pytest.approx(predicted, rel=ROUNDING)
    assert abs(on / off - 1.0) > ANOTHER


@pytest.mark.live
def test_sorting_without_rolling_changes_nothing():
    (switch,) = [s for s in SWITCHES if not s.defect]
    off, on = (energy(switch.case, variant) for variant in (switch.off, switch.on))
    assert on == pytest.approx(off, rel=ROUNDING)


@pytest.mark.live
@pytest.mark.slow
def test_sorting_turns_rolling_round():
    (switch,) = [s for s in SWITCHES if s.words == "rolling, sort 1000"]
    before = [energy(switch.case, variant, 900) for variant in (switch.off, switch.on)]
    after = [energy(switch.case, variant, 2600) for variant in (switch.off, switch.on)]
    assert before[1] == pytest.approx(before[0], rel=ROUNDING)  # the first sort is at step 1000
    assert abs(after[1] / after[0] - 1.0) > ANOTHER


@pytest.mark.live
@pytest.mark.slow
def test_old_walls_without_friction_are_those_of_granular():
    old = [s for s in SWITCHES if s.words in ("walls hooke/history", "walls hertz/history")]
    assert len(old) == 6
    assert {s.case for s in old} == {"silo", "drum", "penetration"}
    for switch in old:
        smooth = [
            Variant(
                replaced={
                    pattern: line.replace(" 0.2 1 ", " 0 1 ")
                    .replace(" 0 0.2 ", " 0 0 ")
                    .replace(" 0 0.2 damping", " 0 0 damping")
                    for pattern, line in variant.replaced.items()
                }
            )
            for variant in (switch.off, switch.on)
        ]
        assert [v.replaced for v in smooth] != [switch.off.replaced, switch.on.replaced]
        granular, style = (energy(switch.case, variant) for variant in smooth)
        assert style == pytest.approx(granular, rel=ROUNDING), switch.words
        rough = [energy(switch.case, variant) for variant in (switch.off, switch.on)]
        assert abs(rough[1] / rough[0] - 1.0) > ANOTHER, switch.words


def need_release(name):
    """Skip a test that needs a release which is not installed."""
    place = Path.home() / ".cache" / "dem-harness" / "releases" / name / "bin" / "lmp"
    if name and not place.exists():
        pytest.skip(f"release {name} is not installed")


@pytest.mark.live
@pytest.mark.slow
def test_walls_of_2022_have_the_moduli_that_their_causes_predict():
    (switch,) = [s for s in SWITCHES if s.defect == "wall-youngs-modulus" and s.case == "silo"]
    need_release(switch.on.release)
    p = default("silo")
    nu = p.poisson_ratio
    # E/(2 (1 - nu)) for E/(2 (1 - nu^2)); E/4 (2 - nu)(1 + nu) for 2 E/((2 - nu)(1 + nu))
    moduli = {
        "kn": (1.0 + nu) * hertz(1.0, nu),
        "kt": 0.25 * (2.0 - nu) * (1.0 + nu),
    }
    right = hertz_wall(p, p.grain, "{E} {kn} {kt} {gamma}").split()
    modulus, gamma = float(right[0]), right[3]
    k_n, k_t = (number(modulus * factor) for factor in moduli.values())
    wall = (
        f"granular hertz {k_n} {gamma} tangential mindlin {k_t} 0 {p.steel_friction} "
        "damping viscoelastic"
    )
    predicted = energy("silo", switch.off | silo_walls(wall))
    off, on = (energy("silo", variant) for variant in (switch.off, switch.on))
    assert on == pytest.approx(predicted, rel=ROUNDING)
    assert abs(on / off - 1.0) > ANOTHER


@pytest.mark.live
@pytest.mark.slow
def test_walls_without_friction_let_a_silo_run_out_faster():
    old = [s for s in SWITCHES if s.defect == "old-wall-friction" and s.case == "silo"]
    control = [s for s in SWITCHES if s.case == "silo" and not s.defect]
    rows = list(table(old + control, 4))
    assert [row.verdict for row in rows] == ["moved", "equivalent", "equivalent"]
    assert rows[0].low > 1.05


def without_friction(case):
    names = [name for name in type(default(case)).model_fields if name.endswith("friction")]
    return Variant({name: 0.0 for name in names if "steel" not in name and "rolling" not in name})


@pytest.mark.live
@pytest.mark.slow
@pytest.mark.parametrize("case", QUANTITIES)
def test_classic_springs_of_grains_are_the_law_but_for_friction(case):
    # the numbers of one of the silo are in its line
    named = [s for s in SWITCHES if "_classic of grains" in s.words and s.case == case]
    classic = [s for s in named if case != "silo" or s.defect == "linear-history-classic"]
    assert len(named) == 2
    for switch in classic:
        rough = [energy(case, variant) for variant in (switch.off, switch.on)]
        assert abs(rough[1] / rough[0] - 1.0) > ANOTHER, switch.words
        smooth = [energy(case, v | without_friction(case)) for v in (switch.off, switch.on)]
        assert smooth[1] == pytest.approx(smooth[0], rel=ROUNDING), switch.words


@pytest.mark.live
@pytest.mark.slow
@pytest.mark.parametrize("case", ["drum", "penetration", "heap"])
def test_springs_that_grains_are_given_are_those_of_their_material(case):
    nu = default(case).poisson_ratio
    stated = between_grains(case, "mindlin", lambda modulus: mindlin(modulus, nu))
    assert energy(case, stated) == pytest.approx(energy(case, Variant()), rel=ROUNDING)


@pytest.mark.live
@pytest.mark.slow
def test_walls_with_the_dashpot_of_tsuji_change_from_the_second_run_on():
    again = {s.case: s for s in SWITCHES if s.defect == "wall-tsuji-again"}
    for release in (OLDEST, OLDER):
        need_release(release)
    for case, switch in again.items():
        new, old = (energy(case, variant) for variant in (switch.off, switch.on))
        assert old == pytest.approx(new, rel=ROUNDING)
    new, old = (energy_of_silo_that_runs_out(v) for v in (again["silo"].off, again["silo"].on))
    assert abs(old / new - 1.0) > ANOTHER
    walls = walled("silo", hertz_wall, HERTZ_WALLS[0])
    new, old = (
        energy_of_silo_that_runs_out(without_restitution("silo", release) | walls)
        for release in (OLDER, OLDEST)
    )
    assert old == pytest.approx(new, rel=ROUNDING)


def energy_of_silo_that_runs_out(variant):
    """Return its kinetic energy [J] 200 steps after the opening."""
    return run_of("silo", variant, 1600, 200).table(silo.COLUMNS)["kinetic_J"][-1]


# ---- report


@pytest.mark.live
@pytest.mark.slow
@pytest.mark.parametrize("case", QUANTITIES)
def test_the_committed_means_are_of_the_cases_as_they_are_now(case):
    """Means of four of the twelve seeds vary by 5 % at most."""
    switch = next(switch for switch in SWITCHES if switch.case == case)
    for quantity, values in runs_of(case, switch.off, 4).values.items():
        row = committed()[switch.defect, case, quantity, switch.words, LAW]
        assert sum(values) / len(values) == pytest.approx(float(row["mean_held"]), rel=0.15)


def committed():
    """Return the rows of the report, by defect, case, quantity, words and what is held against."""
    with (REPORT / "defects.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    names = ("defect", "case", "quantity", "switched", "against")
    return {tuple(row[name] for name in names): row for row in rows}


def test_the_committed_table_is_of_these_switches():
    rows = committed()
    assert list(rows) == [
        (switch.defect or "none", switch.case, quantity, switch.words, against)
        for switch in SWITCHES
        for against in (LAW, *[PREDICTION] * (switch.predicted is not None and not switch.exact))
        for quantity in QUANTITIES[switch.case]
    ] + [row.key for row in unswitched()]
    width = MARGIN.width(1.0)
    for row in rows.values():
        if row["verdict"] == "not tested":
            assert min(int(row["seeds"]), int(row["seeds_held"])) < FEWEST
            continue
        ratio, low, high = (float(row[name]) for name in ("ratio", "low", "high"))
        assert low <= ratio <= high
        assert float(row["mean"]) / float(row["mean_held"]) == pytest.approx(ratio, rel=2e-4)
        within = 1.0 - width <= low and high <= 1.0 + width
        outside = high < 1.0 - width or low > 1.0 + width
        verdict = "equivalent" if within else "moved" if outside else "undecided"
        assert row["verdict"] == verdict


def test_the_committed_table_moves_as_causes_predict():
    rows = {key[:3] + key[4:]: row for key, row in committed().items()}
    # grains that no wall holds run out faster, and a drum that slides below them lifts them less
    silo, drum = (
        rows["old-wall-friction", case, quantity, LAW]
        for case, quantity in (("silo", "discharge_rate_per_s"), ("drum", "surface_angle_deg"))
    )
    assert float(silo["low"]) > 1.05
    assert float(drum["high"]) < 0.95
    (control,) = [row for key, row in committed().items() if key[0] == "none"]
    assert control["verdict"] != "moved"


def test_the_page_has_every_size_of_the_committed_table():
    page = (REPORT / "README.md").read_text(encoding="utf-8")
    rows = {key[:4]: row for key, row in committed().items() if key[4] == LAW}
    for row in rows.values():
        if row["verdict"] != "not tested":
            ratio, low, high = (float(row[name]) for name in ("ratio", "low", "high"))
            assert f"{ratio:.3f} ({low:.3f} to {high:.3f})" in page


def test_every_defect_is_switched_in_every_case_or_says_why_not():
    switched = {(switch.defect, switch.case) for switch in SWITCHES if switch.defect}
    assert not switched & set(UNSWITCHED)
    names = {defect for defect, _ in switched}
    assert switched | set(UNSWITCHED) == {(name, case) for name in names for case in QUANTITIES}


def test_every_cell_of_the_committed_table_has_a_size_or_a_reason():
    rows = committed()
    quantities = [(case, quantity) for case, names in QUANTITIES.items() for quantity in names]
    names = {key[0] for key in rows} - {"none"}
    assert {key[:3] for key in rows if key[0] != "none"} == {
        (name, *quantity) for name in names for quantity in quantities
    }
    for key, row in rows.items():
        reasons = (NOT_RUN, UNSWITCHED.get(key[:2]))
        untested = row["verdict"] == "not tested"
        assert untested == (row["ratio"] == "nan")
        assert not untested or row["without_value"] in reasons


def test_a_command_for_some_switches_leaves_other_rows_as_they_are(tmp_path):
    text = (REPORT / "defects.csv").read_text(encoding="utf-8")
    before = list(read(REPORT / "defects.csv"))
    written(updated(before, []), tmp_path / "defects.csv")
    assert (tmp_path / "defects.csv").read_text(encoding="utf-8") == text
    (row,) = [row for row in before if row.key[:3] == ("none", "silo", "discharge_rate_per_s")]
    after = updated(before, [replace(row, ratio=2.0)])
    changed = [new for old, new in zip(before, after, strict=True) if new.ratio != old.ratio]
    assert [new.ratio for new in changed if not math.isnan(new.ratio)] == [2.0]
    blank = updated([], [])
    assert [row.key for row in blank] == [row.key for row in before]
    assert {row.verdict for row in blank} == {"not tested"}
    assert {row.without_value for row in blank if row.switched} == {NOT_RUN}


def test_every_known_defect_says_what_it_does_in_bulk():
    told = {entry.name: entry.in_bulk for entry in known_defects()}
    assert {re.split("[:,]", words)[0] for words in told.values()} == {
        *("measured", "acts", "once", "fails", "no")
    }
    sizes = {key[0] for key, row in committed().items() if row["verdict"] != "not tested"}
    measured = {name for name, words in told.items() if words.startswith("measured:")}
    assert measured == sizes - {"none", "wall-youngs-modulus"}
    assert told["wall-youngs-modulus"].startswith("measured, with wall-shear-modulus")
    for words in told.values():
        assert not words.startswith("acts") or re.match("acts, not measured: .{15}", words)
        named = re.search("as ([a-z]+-[a-z-]+)", words)
        assert named is None or named[1] in told


def test_table_and_figure(tmp_path):
    rows = table_of([(A, SPREAD), (B, [1.3 * x for x in SPREAD])])
    written(rows, tmp_path / "defects.csv")
    text = (tmp_path / "defects.csv").read_text(encoding="utf-8").splitlines()
    assert text[0].startswith("defect,case,quantity,switched,against")
    assert text[1].endswith("moved,")
    (axes,) = drawn(rows).axes
    assert [text.get_text() for text in axes.texts] == ["silo, rate: on"]
    turned = replace(rows[0], ratio=-0.02, low=-0.05, high=0.01)  # the sign of an angle
    (axes,) = drawn([turned]).axes
    assert axes.get_xlim()[0] < -0.05
    assert axes.get_xscale() == "linear"
