"""``verify --only``: what matches is run, and nothing else."""

import pytest

from harness.cases.registry import get_case
from harness.cases.verification import Study
from harness.engines.registry import open_engine
from harness.errors import RequestError
from harness.workflows.verification import Selection, sections, verify


def selected(case, trials, study):
    """Return the trials of a case that a study selects."""
    return case.verification._selected(trials, study)


BOUNCE = "bounce/hertz, tsuji"


def names(pattern, cases=None, level="quick"):
    return [case.name for case in Selection(cases, pattern).chosen(level)]


def test_a_pattern_finds_cases_submodels_systems_and_checks():
    assert names("oblique") == ["oblique"]
    assert names("OBLIQUE/*/wall") == ["oblique"]
    assert "bounce" in names("*tsuji*")
    assert names("rim_speed_ratio") == [
        *("collision", "lj-units", "oblique", "rolling-resistance", "slip-to-roll")
    ]
    assert names("incline") == ["incline"]
    assert names("incline", "incline,tower") == ["incline"]
    assert names("", "tower") == ["tower"]


def test_a_named_case_that_cannot_list_its_rows_stays_until_they_are_there():
    assert names("*closed form*", "incline") == ["incline"]
    with pytest.raises(RequestError, match="matches no case"):
        names("*closed form*")


@pytest.mark.parametrize(("pattern", "near"), [("oblik", "oblique"), ("hertzz", "hertz")])
def test_a_pattern_that_matches_nothing_is_refused_with_near_names(pattern, near):
    with pytest.raises(RequestError, match=f"--only '{pattern}'.*near it: .*'{near}"):
        names(pattern)


def test_rows_are_kept_by_name_and_by_place():
    case = get_case("bounce")
    trials = list(case.trials("quick"))
    for trial in trials:
        only = f"bounce/{trial.submodel}/{trial.system}"
        same = [one for one in selected(case, trials, Study(only=only)) if one != trial]
        assert all((one.submodel, one.system) == (trial.submodel, trial.system) for one in same)
        assert trial in selected(case, trials, Study(only=only))
    assert not list(selected(case, trials, Study(only="nothing of it")))


class Counted:
    """Hands jobs on to an engine and keeps them."""

    def __init__(self, engine):
        self._engine, self.jobs = engine, []

    def __getattr__(self, name):
        return getattr(self._engine, name)

    def run(self, jobs, *rest, **more):
        self.jobs += jobs
        return self._engine.run(jobs, *rest, **more)


@pytest.mark.live
@pytest.mark.usefixtures("lammps_here")
def test_what_matches_is_run_as_in_the_whole_and_nothing_else():
    found = {}
    for only in ("", BOUNCE):
        with open_engine() as engine:
            counted = Counted(engine)
            chosen = Selection("bounce", only)
            found[only] = (
                verify("quick", cases=chosen, engine=counted, baseline=False),
                counted.jobs,
            )
    (whole, all_jobs), (part, jobs) = found.values()
    cells = {row.cell.submodel for row in part.checks if row.cell}
    assert cells == {"hertz, tsuji"}
    assert 0 < len(jobs) < len(all_jobs)
    values = {row.name: (row.value, row.expected, row.verdict) for row in whole.checks}
    assert {row.name: (row.value, row.expected, row.verdict) for row in part.checks}.items() <= (
        values.items()
    )
    missing = {
        row.name for row in whole.checks if row.cell and row.cell.submodel == "hertz, tsuji"
    } - {row.name for row in part.checks}
    assert not missing
    (section,) = sections(part)
    law, _, commands = section.tables
    assert law.rows[0][1].startswith("F = 4/3 E*")
    assert {row[0] for row in commands.rows} == {row.cell.system for row in part.checks if row.cell}
    (section,) = sections(whole)
    assert section.tables == ()
