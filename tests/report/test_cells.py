"""Pages of the matrix's cells: every mark leads to one, and each leads back to its rows."""

import html
import re
from dataclasses import replace

import pytest

from harness.comparison.known_defects import KnownDefect, mark_known_defects
from harness.comparison.verdicts import (
    Cell,
    Kind,
    Tolerance,
    Verdict,
    failed_run,
    judge,
    not_tested,
)
from harness.errors import EngineNaNError
from harness.report.folder import write
from harness.report.gallery import draw_sections
from harness.report.page import addresses, cell_pages
from harness.report.sections import CellText, Line, Plot, Section, Table

WIDTH = Tolerance("N", 1e-6, 0.0, "a millionth, for a test")
LAW = Table("The law", "As it is.", ("part", "formula"), (("normal", "F = k x"),))


def row(case, submodel, system, quantity="largest_force_N"):
    check = judge(f"{case}, {system}: {quantity}", Kind.ANALYTIC, 0.5 + 1e-9, 0.5, WIDTH)
    return replace(check, cell=Cell(case, submodel, system, "toy", 1.01, 0.99, 1.03))


def text(case, submodel, plots=None):
    line = Line("the law", (0.0, 1.0), (0.0, 2.0))
    plot = Plot("Force over overlap", "A line.", "overlap (m)", "force (N)", (line,))
    runs = (("by hand", "toy -in slope.in -var k 1"),)
    told = ("A sentence.",)
    return CellText(case, submodel, "toy", "TOY", told, (LAW,), runs, plots or (lambda: (plot,)))


def broken():
    raise ArithmeticError("no step")


CELLS = (
    text("slide", "spring/force"),
    text("slide", "spring-force"),
    text("roll", "<old>"),
    text("roll", "spring", broken),
)
ROWS = (
    row("slide", "spring/force", "wall"),
    row("slide", "spring/force", "two spheres"),
    row("slide", "spring-force", "wall"),
    row("roll", "<old>", "wall"),
    row("roll", "spring", "wall"),
)


@pytest.fixture(scope="module")
def found(verification):
    missing = not_tested("roll, wall: spring, toy", Kind.ANALYTIC, "no <floor> there")
    missing = replace(missing, cell=Cell("roll", "spring", "slope", "toy"))
    return replace(verification, checks=(*verification.checks, *ROWS, missing))


@pytest.fixture(scope="module")
def folder(found, tmp_path_factory):
    target = tmp_path_factory.mktemp("cells") / "run"
    write(found, target, [Section("Slides", cells=CELLS[:2]), Section("Rolls", cells=CELLS[2:])])
    return target


def test_every_mark_leads_to_a_page_and_each_page_back_to_its_rows(folder):
    report = (folder / "report.html").read_text()
    marks = re.findall(r'<a href="(cells/[^"]+)" title=', report)
    assert len(marks) == len(ROWS) + 1
    assert {*marks} == {f"cells/{path.name}" for path in (folder / "cells").glob("*.html")}
    assert len({*marks}) == len(CELLS)
    for name in {*marks}:
        page = (folder / name).read_text()
        for link in re.findall(r'href="(?!data:)([^"]+)"', page):
            file, _, place = link.partition("#")
            assert (folder / "cells" / file).resolve().is_file()
            assert not place or f'id="{place}"' in report


def test_a_page_has_rows_with_order_law_figure_commands_and_script(folder):
    (path,) = (folder / "cells").glob("*slide-spring-force.html")
    page = html.unescape(path.read_text())
    assert "<h1>slide: spring/force</h1>" in page
    assert page.count("largest force (N)<") == 2
    assert "0.99 to 1.03" in page
    for told in ("F = k x", "toy -in slope.in -var k 1", "a millionth", "<polyline", "A sentence."):
        assert told in page
    assert 'href="../scripts/slope.in"' in page
    assert "TOY 1 Jan 2030" in page


def test_the_verdict_stands_beside_the_system_where_no_window_cuts_it(folder):
    (path,) = (folder / "cells").glob("*slide-spring-force.html")
    page = path.read_text()
    assert re.findall(r'<th scope="col">(.*?)</th>', page)[:3] == ["system", "verdict", "quantity"]
    rows = re.findall(
        r"<tr><td data-n=\"system\">[^<]+</td><td data-n=\"verdict\"><span class=\"badge", page
    )
    assert len(rows) == page.count('href="../report.html#') - page.count("#matrix")


def test_what_is_said_of_a_row_names_system_and_quantity(found):
    noted = replace(ROWS[2], note="the law asks for another")
    drawn = draw_sections([Section("All", cells=CELLS[1:2])])
    other = replace(ROWS[2], cell=replace(ROWS[2].cell, system="another wall"))
    ((_, page),) = cell_pages(replace(found, checks=(noted, other)), drawn)
    place = f"{ROWS[2].cell.system}, largest force: the law asks for another"
    assert place in html.unescape(page)


def test_an_invariance_is_held_against_the_same_run(found):
    kinds = (Kind.ANALYTIC, Kind.CROSS_CODE, Kind.INVARIANCE)
    rows = [replace(ROWS[2], kind=kind) for kind in kinds]
    drawn = draw_sections([Section("All", cells=CELLS[1:2])])
    ((_, page),) = cell_pages(replace(found, checks=tuple(rows)), drawn)
    told = re.findall(r'<td data-n="by">([^<]*)</td>', page)
    assert sorted(told) == ["closed form", "integration", "the same run"]


def test_rows_of_values_stand_apart_from_what_must_not_change_a_run(found):
    turned = replace(ROWS[2], cell=replace(ROWS[2].cell, invariance="turned"))
    told = replace(CELLS[1], invariances={"turned": "Turned, about the <vertical>."})
    drawn = draw_sections([Section("All", cells=(told,))])
    ((_, page),) = cell_pages(replace(found, checks=(turned, ROWS[2])), drawn)
    values, others = page.index("Limits of a small step<"), page.index("must not change a run<")
    assert values < page.index("largest force (N)<") < others < page.index(">turned<")
    assert page.count("largest force (N)<") == 1
    assert "Turned, about the <vertical>." in html.unescape(page)


def test_an_order_is_printed_only_where_an_error_is_known_to_fall(found):
    drawn = draw_sections([Section("All", cells=CELLS[1:2])])
    ((_, page),) = cell_pages(replace(found, checks=(ROWS[2],)), drawn)
    assert "1.01 (0.99 to 1.03)" in page
    noise = replace(ROWS[2], cell=replace(ROWS[2].cell, order=0.3, order_low=-0.4, order_high=1.0))
    ((_, page),) = cell_pages(replace(found, checks=(noise,)), drawn)
    assert "order (95 %)" not in page
    assert "0.30" not in page


def test_plots_stand_under_their_systems_in_order_each_with_its_caption(found):
    def plots():
        lines = (Line("the law", (0.0, 1.0), (0.0, 2.0)),)
        said = ("Force over overlap", "A line of a law.", "overlap (m)", "force (N)")
        return [
            Plot(*said, lines, group="wall"),
            Plot("Errors", "Of <it>.", "x", "y", (), group="wall"),
            Plot(*said, lines, group="two spheres"),
        ]

    cell = text("slide", "spring/force", plots)
    ((_, page),) = cell_pages(found, draw_sections([Section("All", cells=(cell,))]))
    assert re.findall(r"<h2>(Wall|Two spheres)</h2>", page) == ["Wall", "Two spheres"]
    assert page.count("<polyline") == 2
    assert re.findall(r"</b> *([^<]*)</figcaption>", page) == ["A line of a law."] * 2
    assert "Errors: nothing above zero to draw." in page
    # the rows of the table in the order of the figures
    rows = re.findall(r'<tr><td data-n="system">([^<]+)</td>', page)
    assert rows[:2] == ["wall", "two spheres"]


@pytest.mark.parametrize(
    ("inputs", "expected"),
    [
        (frozenset(), ["drop/slope.in", "pair/slope.in", "slope.in"]),
        (frozenset({"slope"}), ["drop/slope.in", "pair/slope.in", "slope.in"]),
        (frozenset({"pair"}), ["pair/slope.in"]),
    ],
)
def test_a_page_leads_to_no_script_of_another_scene(found, inputs, expected):
    scripts = dict.fromkeys(("slope.in", "pair/slope.in", "drop/slope.in"), "run 0\n")
    cell = replace(CELLS[0], inputs=inputs)
    drawn = draw_sections([Section("All", cells=(cell,))])
    ((_, page),) = cell_pages(replace(found, scripts=scripts), drawn)
    assert sorted(re.findall(r'href="../scripts/([^"]+)"', page)) == expected


DEFECT = KnownDefect(
    name="weak-<spring>",
    engine="toy",
    cases=("slide",),
    submodels=("spring-force",),
    cause="the spring has half of its stiffness",
    predicts={"error": "that is finite"},
    since="1 Jan 2029",
    upstream="issue 1",
    script="reports/defects/weak/in.toy",
)


@pytest.mark.parametrize("script", ["run 0\n", ""])
def test_a_known_defect_stands_on_the_page_with_its_cause_and_its_script(found, tmp_path, script):
    error = EngineNaNError("the toy wrote nothing; that is finite")
    died = failed_run("slide, wall: spring-force, toy", Kind.ANALYTIC, error)
    died = replace(died, cell=ROWS[2].cell)
    (died,) = mark_known_defects([died], [DEFECT], {"toy": "1 Jan 2030"})
    assert died.verdict is Verdict.KNOWN_DEFECT
    known = replace(found, checks=(died, ROWS[0]), defects=((DEFECT, script),))
    write(known, tmp_path / "run", [Section("All", cells=CELLS[:2])])
    pages = tmp_path / "run" / "cells"
    page = html.unescape((pages / "toy-slide-spring-force2.html").read_text())
    assert "weak-<spring></strong>: the spring has half of its stiffness." in page
    assert "Releases from 1 Jan 2029." in page
    assert ">NaN: the toy wrote nothing; that is finite</a>" in page
    assert page.count("half of its stiffness") == 1
    links = re.findall(r'href="../(defects/[^"]+)"', page)
    assert [(tmp_path / "run" / link).read_text() for link in links] == ([script] if script else [])
    assert script or "reports/defects/weak/in.toy" in page
    other = (pages / "toy-slide-spring-force.html").read_text()
    assert "Known defects" not in other
    told = (tmp_path / "run" / "report.md").read_text()
    assert "| known defect: weak-&lt;spring> |" in told
    assert "- weak-&lt;spring>: the spring has half of its stiffness; upstream: issue 1" in told
    assert ("](defects/" in told) == bool(script)


def test_a_page_leads_to_the_scripts_of_its_own_engine(found, declared):
    other = replace(declared[0], engine="pen")
    scripts = dict.fromkeys(("slope.in", "pen/slope.in"), "run 0\n")
    both = replace(found, engines=(other,), scripts=scripts)
    of_pen = replace(CELLS[0], engine="pen")
    drawn = draw_sections([Section("All", cells=(CELLS[0], of_pen))])
    told = [re.findall(r'href="../scripts/([^"]+)"', page) for _, page in cell_pages(both, drawn)]
    assert told == [["slope.in"], ["pen/slope.in"]]


def test_a_plot_that_cannot_be_made_is_named_and_the_page_stands(folder):
    (path,) = (folder / "cells").glob("*roll-spring.html")
    page = path.read_text()
    assert "could not be drawn: ArithmeticError: no step" in page
    assert "no &lt;floor&gt; there" in page
    assert "<polyline" not in page


def test_names_are_escaped_and_the_engine_goes_by_its_title(folder):
    report = (folder / "report.html").read_text()
    assert "Cases and submodels, TOY" in report
    assert "## Cases and submodels, TOY" in (folder / "report.md").read_text()
    assert not any("<old>" in path.read_text() for path in folder.rglob("*.html"))


def test_without_cells_there_is_no_folder_and_marks_lead_to_rows(found, tmp_path):
    write(found, tmp_path / "run", [])
    assert not (tmp_path / "run" / "cells").exists()
    report = (tmp_path / "run" / "report.html").read_text()
    assert re.search(r'<a href="#check-\d+" title=', report)


def test_addresses_differ_where_names_of_files_would_be_alike(found):
    drawn = draw_sections([Section("All", cells=CELLS)])
    assert len({*addresses(drawn).values()}) == len(CELLS)
    assert len([*cell_pages(found, drawn)]) == len(CELLS)


@pytest.mark.parametrize(("width", "scheme"), [(1280, "light"), (390, "dark")])
def test_axe_finds_nothing_on_the_matrix_and_the_pages_of_cells(
    browser, barriers, folder, width, scheme
):
    context = browser.new_context(
        viewport={"width": width, "height": 800}, color_scheme=scheme, reduced_motion="reduce"
    )
    page = context.new_page()
    for file in (folder / "report.html", *sorted((folder / "cells").glob("*.html"))):
        page.goto(file.as_uri())
        assert barriers(page) == [], file.name
        assert page.evaluate("document.documentElement.scrollWidth") == width, file.name
    context.close()


@pytest.mark.parametrize("width", [1400, 390])
def test_no_cell_of_a_table_lies_beyond_its_frame(browser, folder, width):
    page = browser.new_page(viewport={"width": width, "height": 800})
    for file in sorted((folder / "cells").glob("*.html")):
        page.goto(file.as_uri())
        for frame in page.locator(".table").all():
            assert frame.evaluate("node => node.scrollWidth - node.clientWidth") <= 0, file.name
    page.close()


@pytest.mark.parametrize("width", [1280, 390])
def test_the_head_of_a_long_matrix_stays_in_view(browser, found, tmp_path, width):
    rows = tuple(row("slide", f"spring {n}", "wall") for n in range(80))
    write(replace(found, checks=rows), tmp_path / "run")
    page = browser.new_page(viewport={"width": width, "height": 800})
    page.goto((tmp_path / "run" / "report.html").as_uri())
    box = page.locator(".table:has(> .matrix)")
    box.evaluate("node => { node.scrollIntoView(); node.scrollTop = node.scrollHeight; }")
    frame, head, last = (
        one.bounding_box()
        for one in (
            box,
            page.locator(".matrix thead th").first,
            page.get_by_role("rowheader", name="spring 79"),
        )
    )
    assert head["y"] == pytest.approx(frame["y"], abs=2)
    assert last["y"] + last["height"] <= frame["y"] + frame["height"] + 2
    assert frame["height"] <= 0.9 * 800
    page.close()
