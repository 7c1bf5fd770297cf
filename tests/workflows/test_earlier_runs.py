"""Runs of an earlier study: those that are the same are taken from its file, the rest are made."""

import pytest

from harness.cases.contract import Measured
from harness.cases.layers.case import CASE
from harness.cases.layers.system import Layers
from harness.errors import EngineMissingError, EngineOutputError, RequestError
from harness.observables.provenance import Provenance
from harness.workflows.study_run import read_runs, script_digest, study
from harness.workflows.sweep_run import Work, as_frame

UNDECIDED = EngineOutputError("undecided: it never stopped")


def angle(one, ranks):
    return 6.0 + 6.0 / one.layers + 0.01 * one.seed + 0.001 * ranks


class Counted:
    """An executor that notes what it runs; the grain with seed 2 is undecided."""

    def __init__(self):
        self.made = []

    def __call__(self, ranks):
        def run(work):
            for place, one in enumerate(work.parameters):
                self.made.append((ranks, one))
                values = {"stop_angle_deg": angle(one, ranks), "steps": 1000.0}
                done = Measured(values, Provenance(work.engine, "1"), 0.1 + 0.2)
                yield place, UNDECIDED if one.seed == 2 else done

        return run


@pytest.fixture(scope="module")
def first():
    return study("layers", "default", executor_of=Counted())


@pytest.fixture
def file(tmp_path, first):
    as_frame(first.runs).to_csv(tmp_path / "runs.csv", index=False)
    return tmp_path / "runs.csv"


def test_what_is_done_is_not_run_again_and_the_rows_are_the_same_to_the_bit(file, first):
    again = Counted()
    found = study("layers", "default", executor_of=again, earlier=file)
    assert found.runs == first.runs
    assert (first.taken, found.taken) == (0, first.count("done"))
    assert again.made
    assert {one.seed for _, one in again.made} == {2}


def test_another_level_takes_what_it_shares(file):
    quick = Counted()
    study("layers", "quick", executor_of=quick, earlier=file)
    whole = Counted()
    study("layers", "quick", executor_of=whole)
    assert 0 < len(quick.made) < len(whole.made)
    assert {(1, one.seed == 2) for _, one in quick.made} == {(1, True), (1, False)}


def test_runs_on_other_ranks_or_with_another_step_are_other_runs(file):
    one = Layers(layers=1, stiffness_over_weight=300.0, length=24, width=12, first_angle=17.0)
    known, made = read_runs(file, CASE, one), Counted()
    for ranks, some in ((1, one), (2, one), (3, one), (1, one.replace(steps_per_contact=16.0))):
        ((place, ran),) = known.or_run(made(ranks), ranks)(Work(CASE, "lammps", [some]))
        assert place == 0
        assert ran.values["stop_angle_deg"] == angle(some, ranks)
    assert [ranks for ranks, _ in made.made] == [3, 1]
    ((_, other),) = known.or_run(made(1), 1)(Work(CASE, "liggghts", [one]))
    assert other.provenance.engine == "liggghts"


def test_the_places_of_runs_that_are_made_are_theirs(file):
    runs = [Layers(layers=1, stiffness_over_weight=300.0, length=24, width=12, first_angle=17.0,
                   seed=seed) for seed in (9, 1, 8, 2, 3)]  # fmt: skip
    made = Counted()
    known = read_runs(file, CASE, runs[0]).or_run(made(1), 1)
    found = dict(known(Work(CASE, "lammps", runs)))
    assert [one.seed for _, one in made.made] == [9, 2]
    assert isinstance(found.pop(3), EngineOutputError)
    assert {place: ran.values["stop_angle_deg"] for place, ran in found.items()} == {
        place: angle(runs[place], 1) for place in (0, 1, 2, 4)
    }


@pytest.mark.parametrize(
    ("spoil", "told"),
    [
        (lambda text: text.replace("ranks", "cores", 1), "no column ranks; must be the runs.csv"),
        (lambda text: text.replace("arm", "friction", 1), "an unknown column friction; must be"),
        (lambda text: text.replace(",1000.0,", ",many,", 1), "row 2: steps = 'many' must be a fin"),
        (lambda text: text.replace(",1000.0,", ",inf,", 1), "row 2: steps = 'inf' must be a fin"),
        (lambda text: text.replace(",done,", ",done", 1), "row 2: must have as many values as"),
        (lambda text: text[:0], "no column engine; must be"),
        (
            lambda text: text.replace("thickness", '"' + 140000 * "x", 1),
            "is no table .field larger",
        ),
        (
            lambda text: text.replace(script_digest(CASE, "lammps"), "0123456789ab", 1),
            "row 2: script = '0123456789ab': was made by another script of layers; this version's",
        ),
        (
            lambda text: text + text.splitlines()[1].replace(",1000.0,", ",1001.0,") + "\n",
            "the same run as another row, with another result",
        ),
    ],
)
def test_a_file_that_is_none_is_refused_before_anything_runs(file, spoil, told):
    file.write_text(spoil(file.read_text()))
    made = Counted()
    with pytest.raises(RequestError, match=told) as error:
        study("layers", "default", executor_of=made, earlier=file)
    assert "\n" not in str(error.value)
    assert not made.made


def test_runs_that_are_there_stay_where_the_engine_for_the_rest_is_not(file, first):
    def absent(_):
        raise EngineMissingError("no LAMMPS here")

    found = study("layers", "default", executor_of=lambda _: absent, earlier=file)
    assert found.missing == {}
    assert found.count("done") == first.count("done")
    assert {row["reason"] for row in found.runs if row["status"] == "failed"} == {"no LAMMPS here"}
    with pytest.raises(EngineMissingError):
        study("layers", "default", executor_of=lambda _: absent)


def test_a_study_on_more_ranks_says_so_and_its_runs_are_of_these(tmp_path):
    four = study("layers", "default", executor_of=Counted(), least_ranks=4)
    assert {row["ranks"] for row in four.runs} == {4}
    file = tmp_path / "four.csv"
    as_frame(four.runs).to_csv(file, index=False)
    again = study("layers", "default", executor_of=Counted(), earlier=file)
    assert again.taken == 0
    assert {row["ranks"] for row in again.runs} == {1, 2}


def test_no_text_is_refused(tmp_path):
    file = tmp_path / "runs.csv"
    file.write_bytes(b"\xff\xfe\x00a")
    with pytest.raises(RequestError, match=r"runs.csv: is no UTF-8 text"):
        read_runs(file, CASE, Layers())
    with pytest.raises(RequestError, match=r"none.csv: No such file"):
        read_runs(tmp_path / "none.csv", CASE, Layers())
