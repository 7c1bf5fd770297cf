import csv
import shutil
from dataclasses import replace

import numpy as np
import pytest

import harness
from harness.cases.registry import get_case
from harness.comparison.regression import Baseline, BaselineRecord
from harness.comparison.series import Series
from harness.errors import RequestError
from harness.observables.row import Row
from harness.store import acceptance
from harness.store.acceptance import ChangeKind, changes, write
from harness.store.baseline import (
    HEAD,
    committed,
    read_baseline,
    read_tables,
    table_texts,
)

TIME = np.linspace(0.0, 0.1, 1001)
PATH = BaselineRecord(
    name="lammps/path-source",
    parameters={"stiffness": 1e6, "steps": [50, 100.0], "name": None},
    quantities={
        "margin": Row("margin", -1.0 / 3.0, 0.0, ""),
        "step_s": Row("step_s", 1e-300, 5e-324, "s"),
    },
    engine="lammps",
    engine_version='22 Jul 2025, "Update 4"',
    platform="Linux x86_64",
    levels=("quick",),
    case="incline",
    label="path, source",
    family=("source, clipped", "linear"),
    series=Series(TIME, {"x_m": np.sin(TIME), "y_m": np.cos(TIME)}),
)
PLAIN = replace(PATH, name="lammps/angle", series=None, family=())
OTHER = replace(PLAIN, name="exact/tower", engine="exact", case="tower")
EVERYTHING = (PATH, PLAIN, OTHER)


@pytest.fixture
def folder(tmp_path):
    write(changes(EVERYTHING, Baseline({})), tmp_path / "baseline")
    return tmp_path / "baseline"


def test_what_is_written_is_read_again_to_the_last_bit_and_nothing_would_change(folder):
    known = read_baseline(folder)
    assert set(known.records) == {record.name for record in EVERYTHING}
    for record in EVERYTHING:
        assert replace(known.records[record.name], series=record.series) == record
    assert changes(EVERYTHING, known) == []
    series = known.records[PATH.name].series
    assert series.time.size <= 209
    assert np.interp(series.time, TIME, np.sin(TIME)) == pytest.approx(series.columns["x_m"])


def test_a_table_an_engine_sorted_and_one_of_series(folder):
    names = {"lammps.csv", "lammps.series.csv", "exact.csv"}
    assert {path.name for path in folder.iterdir()} == names
    with (folder / "lammps.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [(row["record"], row["quantity"]) for row in rows] == [
        (name, quantity)
        for name in ("lammps/angle", "lammps/path-source")
        for quantity in ("margin", "step_s")
    ]
    assert rows[0]["value"] == "-0.3333333333333333"
    assert table_texts([PATH, PLAIN], "lammps") == table_texts([PLAIN, PATH], "lammps")


def test_a_moved_value_is_one_changed_record_and_levels_add_up(folder):
    known = read_baseline(folder)
    moved = replace(PATH, quantities={**PATH.quantities, "margin": Row("margin", -0.25, 0.0, "")})
    (change,) = changes([replace(moved, levels=("full",)), OTHER], known)
    assert change.kind is ChangeKind.CHANGED
    assert change.lines[0].startswith("margin: -0.3333333333333333 -> -0.25")
    write([change], folder)
    assert read_baseline(folder).records[PATH.name].levels == ("full", "quick")
    assert set(read_baseline(folder).records) == {record.name for record in EVERYTHING}


ROUNDED = Row("margin", np.nextafter(-1.0 / 3.0, 0.0), 0.0, "")


@pytest.mark.parametrize(
    ("change", "kind"),
    [
        ({"quantities": {**PATH.quantities, "margin": ROUNDED}}, ChangeKind.ROUND_OFF),
        ({"engine_version": "new"}, ChangeKind.METADATA),
        ({"series": None}, ChangeKind.CHANGED),
        ({"parameters": {**PATH.parameters, "stiffness": 2e6}}, ChangeKind.CHANGED),
        ({"quantities": {"margin": PATH.quantities["margin"]}}, ChangeKind.CHANGED),
        (
            {"series": Series(TIME, {"x_m": np.sin(TIME) + 1e-6, "y_m": np.cos(TIME)})},
            ChangeKind.CHANGED,
        ),
        (
            {"quantities": {**PATH.quantities, "margin": Row("margin", -1.0 / 3.0, 0.1, "")}},
            ChangeKind.CHANGED,
        ),
    ],
)
def test_round_off_and_metadata_are_told_apart_from_changes(folder, change, kind):
    (found,) = changes([replace(PATH, **change)], read_baseline(folder))
    assert found.kind is kind
    assert found.lines
    assert found.to_json()["case"] == PATH.name


def test_write_that_fails_leaves_the_baseline_as_it_was(folder, monkeypatch):
    before = {path: path.read_text() for path in folder.iterdir()}
    (change,) = changes([replace(PATH, engine_version="new")], read_baseline(folder))

    def fail(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(acceptance, "_write_tables", fail)
    with pytest.raises(RequestError, match="No space left"):
        write([change], folder)
    assert {path: path.read_text() for path in folder.iterdir()} == before
    assert list(folder.parent.iterdir()) == [folder]


def lines(text):
    return text.splitlines(keepends=True)


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (lambda text: text[:-40], "line 5: it ends in the middle"),
        (lambda text: "".join(lines(text)[:-1]) + lines(text)[-1].replace(",", ";", 1), "line 5"),
        (lambda text: text.replace("uncertainty", "error", 1), "line 1: the head is not"),
        (lambda text: text.replace("-0.3333333333333333", "nan", 1), "line 2: value = 'nan' is"),
        (lambda text: text.replace("-0.3333333333333333", "x", 1), "line 2: value = 'x' is not"),
        (lambda text: text.replace("lammps/angle", "yade/angle"), "line 2: record 'yade/angle'"),
        (lambda text: text + lines(text)[-1], "line 6: quantity 'step_s' comes twice"),
        (lambda text: text + lines(text)[1], "line 6: record lammps/angle comes twice"),
        (lambda text: text.replace(",quick,", ",full,", 1), "line 3: it is not of the record"),
        (lambda text: text.replace("stiffness = ", "stiffness", 4), "line 2: parameters"),
    ],
)
def test_a_damaged_table_is_named_with_its_line(folder, damage, said):
    path = folder / "lammps.csv"
    path.write_text(damage(path.read_text()))
    with pytest.raises(RequestError, match=f"baseline file {path} is damaged") as caught:
        read_baseline(folder)
    assert said in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (None, "No such file"),
        (lambda text: "".join(lines(text)[:-1]), "not over the times"),
        (lambda text: lines(text)[0] + "".join(lines(text)[:0:-1]), "out of order"),
        (lambda text: text.replace(",0,1\n", ",0,nan\n"), "value = 'nan' is not a finite"),
        (lambda text: text.replace("path-source", "path-plastic"), "samples of lammps/path-"),
        (lambda text: "".join(x for x in lines(text) if ",y_m," not in x), "the table has"),
    ],
)
def test_a_damaged_series_is_named(folder, damage, said):
    path = folder / "lammps.series.csv"
    text = path.read_text()
    path.unlink() if damage is None else path.write_text(damage(text))
    assert damage is None or path.read_text() != text
    with pytest.raises(RequestError, match=r"lammps\.series\.csv is damaged") as caught:
        read_baseline(folder)
    assert said in str(caught.value)


def test_folders_that_cannot_be(tmp_path):
    with pytest.raises(RequestError, match="no such folder"):
        read_baseline(tmp_path / "none")
    (tmp_path / "file").write_text("")
    with pytest.raises(RequestError, match="is a file"):
        write([], tmp_path / "file")
    package = committed().parents[1] / "harness" / "store" / "committed" / "baseline"
    with pytest.raises(RequestError, match="belongs to the installed package"):
        write([], package)


@pytest.mark.parametrize("engine", ["a/b", "..", "", "x.series", "a b"])
def test_an_engine_whose_name_is_none_of_a_file_is_refused(engine):
    with pytest.raises(RequestError, match="cannot be that of a file"):
        table_texts([PATH], engine)


def test_the_committed_baseline_is_whole_and_as_it_would_be_written():
    known = read_baseline(committed())
    for level in ("quick", "default", "full"):
        assert len(known.of_level(level)) > 40, level
    for record in known.records.values():
        assert set(record.quantities) <= set(get_case(record.case).verification.regression), (
            record.name
        )
        assert record.family
    for table in committed().glob("*.csv"):
        engine = table.name.partition(".")[0]
        texts = table_texts(read_tables(committed() / f"{engine}.csv"), engine)
        assert table.read_text(encoding="utf-8") == texts[table.name]


def test_a_baseline_that_a_checkout_lacks_is_an_error_and_not_nothing(tmp_path, monkeypatch):
    (tmp_path / "harness").mkdir()
    (tmp_path / "pyproject.toml").touch()
    monkeypatch.setattr(harness, "__file__", str(tmp_path / "harness" / "__init__.py"))
    with pytest.raises(RequestError, match=r"reports/baseline: is missing in this checkout"):
        committed()
    target = tmp_path / "reports" / "baseline"
    target.mkdir(parents=True)
    with pytest.raises(RequestError, match="is missing in this checkout"):
        committed()
    (target / "lammps.csv").write_text(",".join(HEAD) + "\n")
    assert committed() == target


def test_a_wheel_finds_its_own(tmp_path, monkeypatch):
    package = tmp_path / "site-packages" / "harness"
    own = package / "store" / "committed" / "baseline"
    monkeypatch.setattr(harness, "__file__", str(package / "__init__.py"))
    assert committed() is None
    shutil.copytree(harness_baseline, own)
    assert committed() == own


harness_baseline = committed()
