"""Bulk cases in other codes: recorded runs, small runs beside LAMMPS, planted faults."""

import math

import pytest

from harness.engines.contract import Job
from harness.engines.lammps.engine import Lammps
from harness.engines.registry import engine_class
from harness.errors import EngineLostAtomsError, EngineOutputError, EngineUndecidedError
from tests.cases.bulk.doubles import CASES, SMALL, changed, needs, recorded, replaced, run

CODES = ("yade", "kratos")
PENETRATION, SILO, DRUM, HEAP = (CASES[n] for n in ("penetration", "silo", "drum", "heap"))
ALL = pytest.mark.parametrize("case", CASES.values(), ids=CASES)
EACH = pytest.mark.parametrize("code", CODES)


def small_job(case, **changes):
    """Return the job of a small run."""
    values = dict(case.job(SMALL[case.name]).values)
    return Job(case.template, {**values, **changes}, sampled=True)


@ALL
@EACH
def test_quantities_are_read_from_a_recorded_run(code, case):
    found = case.measure(SMALL[case.name], recorded(code, case))
    springs = {
        "elastic_ratio",
        "end_elastic_ratio",
        "balance_ratio",
    }  # scripts of LAMMPS alone leave them
    springs = set() if case is DRUM else springs  # computed from places
    assert set(found) == {quantity.name for quantity in case.quantities} - springs
    assert all(math.isfinite(value) for value in found.values())
    assert found.get("energy_gain_ratio", 0.0) < 0.02
    assert found.get("bed_solid_fraction", 0.5) == pytest.approx(0.5, abs=0.12)
    if case is SILO:  # the walls bear what does not move
        assert found["walls_load_ratio"] == pytest.approx(1.0, abs=0.08)
        assert found["passed_ratio"] == 1.0
    if case is HEAP:
        assert 15.0 < found["angle_deg"] < 40.0
        assert 0.3 < found["remaining_ratio"] < 0.9
    if case is DRUM:  # grains rise at x < 0, so that the surface falls along +x
        assert 0.0 < found["surface_angle_deg"] < 40.0


@EACH
def test_damaged_output_is_an_error(code):
    p = SMALL["penetration"]
    for said, other, error in (
        ("outside = 0", "outside = 1", EngineLostAtomsError),
        ("grains = 90", "grains = 89", EngineOutputError),
    ):
        output = recorded(code, PENETRATION, lambda text: text.replace(said, other))  # noqa: B023
        with pytest.raises(error, match=r"a particle passed a wall|grains = 89"):
            PENETRATION.measure(p, output)
    with pytest.raises(EngineOutputError, match="incomplete series"):
        recorded(code, SILO, series=lambda text: text.replace(",", "", 7))


@pytest.mark.live
@pytest.mark.slow
@ALL
@pytest.mark.parametrize("code", ["liggghts", *CODES])
def test_a_small_run_begins_as_lammps_s_and_settles_to_the_same_height(code, case):
    """Places at the start are one formula: after 10 steps of fall heights agree to round-off.

    A drum's grains are in another order: those of each kind are compared by their means.
    """
    needs(code)
    p = SMALL[case.name]
    short = {"settle_steps": 0 if case is DRUM else 10, "steps": 10, "series_every": 10}
    with Lammps() as engine:
        mine, first = engine.run([small_job(case), small_job(case, **short)])
    theirs, begun = run(engine_class(code), small_job(case), small_job(case, **short))
    if case is DRUM:
        for name in ("x_m", "y_m", "z_m"):
            one, other = (o.tables["series"][name][0] for o in (first, begun))
            for kind in (slice(0, p.large_grains), slice(p.large_grains, None)):
                assert other[kind].mean() == pytest.approx(one[kind].mean(), abs=1e-8), name
    else:
        one, other = (o.number("mean_height_m") for o in (first, begun))
        assert other == pytest.approx(one, rel=1e-8)
    if case is DRUM:  # where the bed of some grains lies at the end
        ends = [
            [o.tables["series"][name][-1].mean() for name in ("x_m", "z_m")] for o in (mine, theirs)
        ]
        assert ends[1] == pytest.approx(ends[0], abs=0.05 * p.drum_radius)
        return
    found = [case.measure(p, o) for o in (mine, theirs)]
    if case is HEAP:
        shares = [one["remaining_ratio"] for one in found]
        assert shares[1] == pytest.approx(shares[0], rel=0.25)
        return
    name = "bed_solid_fraction"
    assert found[1][name] == pytest.approx(found[0][name], rel=0.05)
    if case is SILO:  # a bed that is not quite at rest
        assert found[1]["walls_load_ratio"] == pytest.approx(1.0, abs=0.15)


HOLE = '"open_facets": 0'
FAULTS = [
    ("silo", (HOLE, '"open_facets": 20'), EngineLostAtomsError),
    ("silo", ("self.spheres.remove_wall(self.floor)", "pass"), EngineUndecidedError),
    ("drum", ("turn(self.wall, p.speed)", "turn(self.wall, -p.speed)"), AssertionError),
    ("penetration", ("for place, normal in walls:", "for place, normal in walls[1:]:"),
     EngineLostAtomsError),
    ("heap", ("in ((low, (0, 1, 0)), (high, (0, -1, 0))):", "in ((high, (0, -1, 0)),):"),
     EngineLostAtomsError),
    ("heap", ("for end in self.ends:", "for end in ():"), EngineUndecidedError),
]  # fmt: skip
IN_LAMMPS = [
    ("lammps", "heap", ("fix sides grains", "fix sides glued"), EngineLostAtomsError),
    ("lammps", "heap", ("unfix ends", ""), EngineUndecidedError),
]


@pytest.mark.live
@pytest.mark.slow
@pytest.mark.parametrize(
    ("code", "name", "fault", "error"),
    [*((code, *fault) for code in CODES for fault in FAULTS), *IN_LAMMPS],
)
def test_a_planted_fault_turns_a_bulk_case(code, name, fault, error):
    """A hole, a closed orifice, a drum that turns backward, no floor, no side, ends that stay."""
    needs(code)
    case = CASES[name]
    kind = changed(engine_class(code), lambda text: replaced(text, fault))

    def found():
        (output,) = run(kind, small_job(case))
        assert case.measure(SMALL[name], output)["surface_angle_deg"] > 0.0

    with pytest.raises(error):
        found()
