import json
from dataclasses import replace

import numpy as np
import pytest

import harness
from harness.comparison.baseline_record import BaselineRecord, Quantity
from harness.comparison.divergence import Series
from harness.comparison.regression import Baseline
from harness.comparison.regression_tolerances import REGRESSION
from harness.errors import RequestError
from harness.store import acceptance
from harness.store.acceptance import changes, write
from harness.store.baseline import case_text, committed, committed_tolerances, read_baseline
from harness.store.overrides import read_overrides

TIME = np.linspace(0.0, 0.1, 1001)
CASE = BaselineRecord(
    name="lammps/incline-path-source-10.2-deg",
    parameters={"stiffness": 1e6, "steps": [50, 100.0], "name": None},
    quantities={"margin_over_mgd": Quantity(-1.0 / 3.0, 0.0, "")},
    engine="lammps",
    engine_version="22 Jul 2025",
    platform="Linux x86_64",
    levels=("quick",),
    series=Series(TIME, {"x_m": np.sin(TIME), "y_m": np.cos(TIME)}),
)
OTHER = replace(CASE, name="exact/tower", series=None)


@pytest.fixture
def folder(tmp_path):
    write(changes([CASE, OTHER], Baseline({})), tmp_path / "baseline")
    return tmp_path / "baseline"


def test_what_is_written_is_read_again_and_nothing_would_change(folder):
    known = read_baseline(folder)
    assert set(known.cases) == {CASE.name, OTHER.name}
    assert known.cases[CASE.name].quantities == CASE.quantities
    assert changes([CASE, OTHER], known) == []
    series = known.cases[CASE.name].series
    assert series.time.size <= 209
    assert np.interp(series.time, TIME, np.sin(TIME)) == pytest.approx(series.columns["x_m"])


def test_files_are_indented_sorted_and_small(folder):
    text = (folder / f"{CASE.name}.json").read_text()
    record = json.loads(text)
    assert text == json.dumps(record, indent=2, sort_keys=True) + "\n"
    assert (folder / f"{CASE.name}.csv").stat().st_size < 20_000


def test_a_moved_value_is_one_changed_case_and_levels_add_up(folder):
    known = read_baseline(folder)
    moved = replace(CASE, quantities={"margin_over_mgd": Quantity(-0.25, 0.0, "")})
    (change,) = changes([replace(moved, levels=("full",)), OTHER], known)
    assert change.kind == "changed"
    assert change.lines[0].startswith("margin_over_mgd: -0.3333333333333333 -> -0.25")
    write([change], folder)
    assert read_baseline(folder).cases[CASE.name].levels == ("full", "quick")
    assert OTHER.name in read_baseline(folder).cases


def test_case_that_loses_its_series_loses_the_file(folder):
    (change,) = changes([replace(CASE, series=None)], read_baseline(folder))
    write([change], folder)
    assert not (folder / f"{CASE.name}.csv").exists()


def test_write_that_fails_leaves_the_baseline_as_it_was(folder, monkeypatch):
    before = {path: path.read_text() for path in folder.rglob("*.*")}
    (change,) = changes([replace(CASE, engine_version="new")], read_baseline(folder))

    def fail(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(acceptance, "_write_case", fail)
    with pytest.raises(RequestError, match="No space left"):
        write([change], folder)
    assert {path: path.read_text() for path in folder.rglob("*.*")} == before
    assert list(folder.parent.iterdir()) == [folder]


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (lambda text: text[:100], "line"),
        (lambda text: text.replace('"quantities"', '"numbers"'), "'quantities' is missing"),
        (lambda text: text.replace("-0.3333333333333333", "NaN"), "not a finite number"),
        (lambda text: text.replace("-0.3333333333333333", '"x"'), "not a finite number"),
        (lambda text: text.replace("path-source", "path-plastic"), "it says it is case"),
        (lambda _: "[]", "list"),
        (lambda _: "", "line 1"),
    ],
)
def test_damaged_file_is_named(folder, damage, said):
    path = folder / f"{CASE.name}.json"
    path.write_text(damage(path.read_text()))
    with pytest.raises(RequestError, match=f"baseline file {path} is damaged") as caught:
        read_baseline(folder)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("text", [None, "", "time_s,x_m\n1,2\n", "time_s,x_m\n0,1\n1,nan\n"])
def test_damaged_series_is_named(folder, text):
    path = folder / f"{CASE.name}.csv"
    path.unlink() if text is None else path.write_text(text)
    with pytest.raises(RequestError, match=r"incline-path-source-10\.2-deg\.json is damaged"):
        read_baseline(folder)


def test_folders_that_cannot_be(tmp_path):
    with pytest.raises(RequestError, match="no such folder"):
        read_baseline(tmp_path / "none")
    (tmp_path / "file").write_text("")
    with pytest.raises(RequestError, match="is a file"):
        write([], tmp_path / "file")
    package = committed().parents[1] / "harness" / "store" / "committed" / "baseline"
    with pytest.raises(RequestError, match="belongs to the installed package"):
        write([], package)


def test_the_committed_baseline_is_whole():
    known = read_baseline(committed())
    for level in ("quick", "default", "full"):
        assert len(known.of_level(level)) > 40, level
    for case in known.cases.values():
        assert set(case.quantities) <= set(REGRESSION), case.name
        text = (committed() / f"{case.name}.json").read_text(encoding="utf-8")
        assert text == case_text(case)


def test_a_wheel_finds_its_own(tmp_path, monkeypatch):
    package = tmp_path / "site-packages" / "harness"
    (package / "store" / "committed" / "baseline").mkdir(parents=True)
    monkeypatch.setattr(harness, "__file__", str(package / "__init__.py"))
    assert committed() == package / "store" / "committed" / "baseline"
    assert committed_tolerances() is None


OVERRIDE = """
[override.soft]
case = "lammps/*"
quantity = "critical_angle_deg"
absolute = 1e-4
reason = "contacts of the soft case break at another step here"
"""


def test_overrides_are_read(tmp_path):
    path = tmp_path / "tolerances.toml"
    path.write_text(OVERRIDE)
    (override,) = read_overrides(path)
    assert (override.name, override.case) == ("soft", "lammps/*")
    assert override.tolerance.width(10.0) == 1e-4
    assert override.tolerance.unit == "deg"
    assert read_overrides(committed_tolerances()) == ()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (OVERRIDE.replace("1e-4", "-1.0"), "absolute = -1.0: must be finite and at least 0"),
        (OVERRIDE.replace("1e-4", "true"), "absolute = True"),
        (OVERRIDE.replace("quantity", "quality"), "quantity = None: must be a text"),
        (OVERRIDE + 'unit = "deg"\n', "unit is not known"),
        ("[tolerance]\n", "and nothing else"),
        ("[override", "cannot be read"),
        (OVERRIDE.replace("contacts of the soft case break at another step here", "so"), "why"),
    ],
)
def test_bad_overrides_are_named(tmp_path, text, said):
    path = tmp_path / "tolerances.toml"
    path.write_text(text)
    with pytest.raises(RequestError, match=f"--tolerances {path}") as caught:
        read_overrides(path)
    assert said in str(caught.value)
