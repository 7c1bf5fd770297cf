"""The report's section on engines beside one another."""

import csv
import json
from dataclasses import replace

import jsonschema
import pytest

from harness.comparison.engine_evidence import (
    EngineEvidence,
)
from harness.comparison.results import Results
from harness.report.engines import TITLE, tables
from harness.report.figures.engines import angles_of_engines, tower_error_against_step
from harness.report.finite import finite
from harness.report.folder import write
from harness.report.page import html_page
from harness.report.schema import published
from harness.report.text import markdown

CLOSED = 10.2


@pytest.fixture(scope="module")
def found(verification, engine_evidence):
    return replace(verification, engines=engine_evidence)


@pytest.fixture(scope="module")
def target(found, tmp_path_factory):
    folder = tmp_path_factory.mktemp("reports") / "run"
    write(found, folder)
    return folder


def test_each_engine_and_case_has_its_row(engine_evidence):
    angles, towers, about = tables(engine_evidence)
    assert [row[0] for row in angles.rows] == [a.engine for a in engine_evidence.angles]
    row = dict(zip(angles.head, angles.rows[0], strict=True))
    assert row["angle (deg)"] == "10.20030 ± 0.0003"
    assert row["less theory"] == "+0.0003"
    assert row["less reference"] == "+0.0001"
    assert row["µs per step"] == "4.9"
    assert row["class"] == "clipped, m, linear"
    assert [row[-1] for row in angles.rows] == [
        "independent", "regression partner", "recorded", "the harness's own",
    ]  # fmt: skip
    assert towers.head == ("engine", "steps", "n = 1", "n = 4", "order")
    assert towers.rows[0][2] == "1.0e-05"
    assert [row[-1] for row in about.rows] == [
        "qualified", "qualified", "missing: no esysparticle here", "did not qualify: free fall",
    ]  # fmt: skip


def test_empty_tables_are_left_out():
    assert tables(EngineEvidence(CLOSED)) == []


def test_page_and_markdown_have_the_section_with_figures_and_traps(target):
    page, text = ((target / name).read_text() for name in ("report.html", "report.md"))
    assert 'href="#engines"' in page
    assert 'id="engines"' in page
    assert "It &lt;always&gt; clips. It counts m/2." in page
    assert f"## {TITLE}" in text
    assert "| yade | plastic | 1e+06 | 100 |" in text
    for name in ("engines-critical-angle", "engines-tower-error"):
        assert f'id="{name}"' in page
        assert (target / "figures" / f"{name}.svg").is_file()


def test_without_engines_there_is_no_section(verification):
    page = html_page(verification, [])
    assert 'href="#engines"' not in page
    assert TITLE not in page
    assert TITLE not in markdown(verification, [])
    assert verification.record()["engines"] is None


def test_results_are_valid_and_read_back(found, engine_evidence, target):
    record = json.loads((target / "results.json").read_text())
    schema = json.loads(published())
    jsonschema.Draft202012Validator(schema).validate(record)
    parts = {
        "declared": "DeclaredRow",
        "critical_angles": "EngineAngleRow",
        "towers": "EngineTowerRow",
    }
    for key, model in parts.items():
        assert set(record["engines"][key][0]) == set(schema["$defs"][model]["properties"])
    read = Results.model_validate(finite(found.record()))
    assert read.engines.critical_angles[0].critical_angle_deg == engine_evidence.angles[0].value_deg
    rows = list(csv.DictReader((target / "results.csv").read_text().splitlines()))
    assert [row["name"] for row in rows] == [check.name for check in found.checks]


def test_the_figure_of_angles_has_a_row_for_each_and_tells_contacts_apart(engine_evidence):
    figure = angles_of_engines(engine_evidence.angles, CLOSED)
    whole, near = figure.axes
    names = [label.get_text() for label in whole.get_yticklabels()]
    assert len(names) == 4
    assert "mfix (recorded): plastic, 100 steps" in names
    (legend,) = figure.legends
    said = {text.get_text() for text in legend.get_texts()}
    assert said == {
        "closed form", "± 0.003 deg", "reference DEM, same rules", "engine, clipped tail",
        "engine, attractive tail",
    }  # fmt: skip
    assert [text.get_text() for text in near.texts] == ["+46 →"]


def test_the_figure_of_angles_keeps_to_one_stiffness_and_step(engine_evidence):
    beside = [
        replace(engine_evidence.angles[0], stiffness=1e5),
        replace(engine_evidence.angles[0], engine="x"),
    ]
    figure = angles_of_engines([*engine_evidence.angles, *beside], CLOSED)
    assert len(figure.axes[0].get_yticklabels()) == 5


def test_the_figure_of_towers_has_slopes_to_go_by(engine_evidence):
    (axes,) = tower_error_against_step(engine_evidence.convergence).axes
    assert [text.get_text() for text in axes.texts] == ["slope 1", "slope 2"]
    (name,) = [text.get_text() for text in axes.get_legend().get_texts()]
    assert name.startswith("yade, order ")
    for slope, line in zip((1, 2), axes.get_lines()[1:], strict=True):
        x, y = line.get_data()
        assert y[0] / y[-1] == pytest.approx((x[-1] / x[0]) ** slope)
