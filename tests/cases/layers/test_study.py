"""The study of layers: what is run, intervals that cover, the test of softness, the fit."""

import math
from collections import Counter

import numpy as np
import pytest

from harness.cases.layers.averages import (
    Mean,
    difference_of,
    extrapolated,
    fit_over_thickness,
    mean_of,
    unpaired,
)
from harness.cases.layers.case import CASE
from harness.cases.layers.changes import Change
from harness.cases.layers.conclusion import TEST, judged
from harness.cases.layers.cost import Speed, durations_of
from harness.cases.layers.extents import RANKS
from harness.cases.layers.study import LIMIT, REFERENCE, THICKNESS, LayersStudy, grains_in
from harness.cases.source_angles import READINGS, source_angles
from harness.errors import RequestError
from harness.observables.reference import ReferencePoints
from harness.parameters.base import Parameters
from harness.report.figures.style import house_style
from harness.workflows.sweep_run import key_of

STUDY = LayersStudy()
KEYS = {"layers", "stiffness_over_weight", "restitution", "stop_angle_deg", "uncertainty_deg",
        "grains", "seeds"}  # fmt: skip


@pytest.mark.parametrize("level", ["quick", "default", "full"])
def test_every_level_has_thickness_at_two_stiffnesses_and_the_single_grain(level):
    arms = {arm.name: arm for arm in STUDY.arms(level)}
    assert {THICKNESS, REFERENCE, LIMIT} <= set(arms)
    runs = arms[THICKNESS].parameters
    pairs = {(one.layers, one.stiffness_over_weight) for one in runs}
    layers, stiffnesses = ({pair[i] for pair in pairs} for i in (0, 1))
    if level != "quick":
        assert {1, 2, 4, 8} <= layers
        assert max(stiffnesses) >= 100 * min(stiffnesses)
        split = [arm.parameters[0] for arm in arms.values() if arm.ranks == RANKS]
        assert {(one.layers > 1, one.stiffness_over_weight > 1e3) for one in split} >= {
            (False, False), (True, True)
        }  # fmt: skip
    # the same base and places at every stiffness: differences are paired by seed
    seeds = {pair: {one.seed for one in runs if key(one) == pair} for pair in pairs}
    for height in layers:
        counts = sorted((seeds[pair] for pair in pairs if pair[0] == height), key=len)
        assert all(some >= counts[0] for some in counts)


def key(one):
    return one.layers, one.stiffness_over_weight


def key_of_row(one):
    return one["layers"], one["stiffness_over_weight"]


SEEDS = Counter(map(key, STUDY.arms("default")[0].parameters))


def test_the_interval_is_that_of_student_where_the_bootstrap_is_narrower():
    values = [9.0, 9.2, 9.1, 9.5]
    found = mean_of(values)
    # t of three degrees of freedom at 97.5 %: 3.182446
    student = 3.182446 * np.std(values, ddof=1) / 2
    assert found == Mean(9.2, pytest.approx(student, rel=1e-6), 4, pytest.approx(0.216, abs=1e-3))
    assert math.isnan(mean_of([9.0]).half_width)
    assert math.isnan(mean_of([]).value)


def test_intervals_cover_the_mean_as_often_as_they_say():
    """Of 400 samples of four the 95 % interval misses some twenty, with a spread of four."""
    rng = np.random.default_rng(1)
    samples = (mean_of(rng.normal(5.0, 0.3, 4)) for _ in range(400))
    missed = sum(not one.low <= 5.0 <= one.high for one in samples)
    assert missed <= 20 + 3 * math.sqrt(400 * 0.05 * 0.95)


def test_pairing_takes_the_seeds_that_both_have():
    one, other = {1: 9.0, 2: 9.5, 3: 8.0}, {2: 9.0, 3: 7.6, 4: 1.0}
    found = difference_of(one, other)
    assert (found.value, found.count) == (pytest.approx(0.45), 2)
    apart = unpaired(Mean(9.0, 0.3, 4), Mean(8.0, 0.4, 4))
    assert (apart.value, apart.half_width) == (1.0, pytest.approx(0.5))


@pytest.mark.parametrize(
    ("difference", "word"),
    [
        (Mean(0.1, 0.15, 4), "the same"),
        (Mean(0.2, 0.05, 4), "the same"),
        (Mean(-0.6, 0.2, 4), "depends on softness"),
        (Mean(0.4, 0.2, 4), "depends on softness"),
        (Mean(0.1, 0.5, 4), "undecided"),
        (Mean(0.4, math.nan, 1), "undecided"),
    ],
)
def test_the_word_follows_from_interval_and_margin(difference, word):
    assert judged(difference) == word


@pytest.mark.parametrize(
    ("difference", "own", "word"),
    [
        (Mean(0.1, 0.15, 4), 0.0, "yes"),
        (Mean(0.02, 0.01, 4), 0.1, "yes"),
        (Mean(-0.12, 0.1, 4), 0.1, "within 0.3 deg"),
        (Mean(0.2, 0.15, 4), 0.1, "no"),
        (Mean(-0.8, 0.2, 4), 0.3, "no"),
    ],
)
def test_a_change_moves_the_angle_little_where_softness_would_be_told_to_do_nothing(
    difference, own, word
):
    assert Change("another", Mean(9.0, own, 4), difference, own).word == word
    if word == "within 0.3 deg":
        assert judged(difference) == "the same"


def test_the_fit_finds_the_law_that_it_was_given():
    """With noise of 0.05 deg its intervals hold the limit and the exponent of the law."""
    rng = np.random.default_rng(3)
    law = {h: 5.76 + 8.0 * h**-0.7 for h in (1, 2, 4, 8, 16)}
    angles = {h: list(angle + rng.normal(0.0, 0.05, 6)) for h, angle in law.items()}
    fit = fit_over_thickness(angles)
    assert fit.limit_interval[0] < 5.76 < fit.limit_interval[1]
    assert fit.exponent_interval[0] < 0.7 < fit.exponent_interval[1]
    exact = fit_over_thickness({h: [angle, angle] for h, angle in law.items()})
    assert (exact.limit, exact.exponent) == (
        pytest.approx(5.76, abs=1e-3),
        pytest.approx(0.7, abs=1e-3),
    )
    assert exact.curve(np.array([4.0]))[0] == pytest.approx(law[4], abs=1e-4)
    with pytest.raises(RequestError, match="needs four thicknesses"):
        fit_over_thickness({1: [1.0, 2.0], 2: [1.0, 2.0]})


def test_the_limit_is_that_of_the_line_that_the_means_lie_on():
    x = (0.025, 0.05, 0.1)
    means = [Mean(9.0 + 4.0 * one, 0.1, 4) for one in x]
    found = extrapolated(x, means)
    assert found.value == pytest.approx(9.0)
    # the variance of the intercept of a line: sigma^2 sum x^2 / (n sum x^2 - (sum x)^2)
    squares, total = sum(one**2 for one in x), sum(x)
    assert found.half_width == pytest.approx(0.1 * math.sqrt(squares / (3 * squares - total**2)))
    with pytest.raises(RequestError, match="needs three values, 2 are there"):
        extrapolated(x[:2], means[:2])


def test_the_readings_of_the_paper_fall_and_rise_from_the_single_grain():
    angles = [source_angles(n, "deformable") for n in (1, 3, 8)]
    lost, kept = ([one[reading] for one in angles] for reading in READINGS)
    assert lost[0] == kept[0] == pytest.approx(10.2078, abs=1e-4)
    assert lost[0] > lost[1] > lost[2] > 4.5
    assert kept[0] < kept[1] < kept[2]


def row(one: Parameters, ranks, angle):
    """Return a run as a sweep makes it, with an angle of stop, None for one that is undecided."""
    values = {**one.model_dump(mode="json"), "contact.restitution": one.contact.restitution}
    units = {"length": "d", "width": "d", "filled": "d", "rate": "deg", "rise": "deg"}
    told = {key_of(name, units.get(name, "")): value for name, value in values.items()}
    around = None if angle is None else angle + 1e-3
    return {
        "ranks": ranks,
        **told,
        "stop_angle_deg": angle,
        "start_angle_deg": angle + 1.2 if angle is not None and one.rise else None,
        "stop_angle_at_100_times_the_ratio_deg": around,
        "stop_angle_by_speed_deg": around,
        "rest_coordination": 6.0,
    }


def angles(softness):
    """Return the rows of level default in a world where softness lowers angles by so much."""
    rng = np.random.default_rng(0)
    rows = {}
    for arm in STUDY.arms("default"):
        if arm.name == LIMIT:
            rows[arm.name] = [row(one, 1, 10.2 - one.rate / 2) for one in arm.parameters]
            continue
        rows[arm.name] = [
            row(one, arm.ranks, 5.0 + 8.0 / one.layers + 0.05 * rng.normal()
                - softness * (one.stiffness_over_weight < 1e3))
            for one in arm.parameters
        ]  # fmt: skip
    return rows


@pytest.mark.parametrize(
    ("softness", "words"),
    [
        (0.0, "The angle does not depend on softness at any thickness"),
        (1.0, "The angle depends on softness at every thickness"),
    ],
)
def test_the_verdict_is_the_one_of_the_world_that_it_was_shown(softness, words):
    found = STUDY.conclude(angles(softness), ReferencePoints("mine.csv", (1.0, 5.0), (12.0, 8.0)))
    assert any(words in sentence for sentence in found.verdict)
    assert any("falls with every step in thickness" in sentence for sentence in found.verdict)
    assert "Stated in the code" in found.test == TEST
    assert all(set(one) >= KEYS for one in found.rows)
    assert {one["arm"] for one in found.rows} == {arm.name for arm in STUDY.arms("default")}
    thick = [one for one in found.rows if one["arm"] == THICKNESS]
    assert {key_of_row(one): one["seeds"] for one in thick} == SEEDS
    titles = [section.title for section in found.sections]
    assert titles == ["Thickness", "Softness", "What else could move the angle",
                      "The limit of a single grain"]  # fmt: skip
    assert any("length of the box to infinity" in item for item in found.sections[2].items)
    with house_style():
        drawing, boxes = [one for section in found.sections for one in section.drawings]
        (axes,), (over_box,) = drawing.draw().axes, boxes.draw().axes
    assert over_box.get_legend_handles_labels()[1] == [
        "1 layer at 300 weights", "2 layers at 300 weights", "2 layers at 30000 weights",
        "4 layers at 300 weights", "4 layers at 30000 weights", "8 layers at 300 weights",
        "8 layers at 30000 weights",
    ]  # fmt: skip
    # a line to an endless box where there are three
    ends = [list(line.get_xdata()) for line in over_box.lines]
    assert [one for one in ends if len(one) == 2 and one[0] == 0.0] == [
        [0.0, 1 / 16], [0.0, 1 / 16], [0.0, 1 / 16], [0.0, 1 / 12], [0.0, 1 / 12]
    ]  # fmt: skip
    labels = " ".join(axes.get_legend_handles_labels()[1])
    assert all(word in labels for word in ("lost", "kept", "10.2078", "Peyneau", "mine.csv"))


def test_undecided_runs_are_told_and_are_no_angles():
    rows = angles(0.0)
    rows[THICKNESS] = [{**one, "stop_angle_deg": None} if one["layers"] == 8 else one
                       for one in rows[THICKNESS]]  # fmt: skip
    rows["2 ranks"] = []
    found = STUDY.conclude(rows, None)
    lost = {key: count for key, count in SEEDS.items() if key[0] == 8}
    told = f"Without an angle: {sum(lost.values())} runs"
    assert any(told in sentence for sentence in found.verdict)
    thick = [one for one in found.rows if one["arm"] == THICKNESS and one["layers"] == 8]
    assert {key_of_row(one): (one["seeds"], one["undecided"]) for one in thick} == {
        key: (0, count) for key, count in lost.items()
    }
    nothing = {
        name: [{**one, "stop_angle_deg": None} for one in some] for name, some in rows.items()
    }
    told = STUDY.conclude(nothing, None)
    assert told.verdict[0] == "No run stopped: there is no angle."


def test_the_case_declares_it():
    assert isinstance(CASE.study(), LayersStudy)


def changed(rows, name, by):
    """Return the rows with the angles of an arm moved by so much."""
    return {**rows, name: [{**one, "stop_angle_deg": one["stop_angle_deg"] + by}
                           for one in rows[name]]}  # fmt: skip


def test_a_change_that_moves_the_angle_little_is_told_apart_from_one_that_moves_it():
    place = ", 2 layers at 300 weights"
    rows = changed(angles(0.0), f"larger box{place}", 0.15)
    told = counted(rows).partition("at the widest)")[2]
    assert "It moves, but stays within 0.3 deg, in " in told
    assert "larger box, 30 x 15 for 20 x 10 d at 2 layers at 300 weights: +0.1" in told
    assert "30 x 15" not in told.partition("moves further")[2]


def test_changes_at_more_layers_are_held_against_the_runs_over_the_thickness():
    moved = "twice the rate, 2 layers at 30000 weights"
    found = STUDY.conclude(changed(angles(0.0), moved, -1.0), None)
    (told,) = [one for one in found.verdict if "definition of the arrest" in one]
    assert "twice the rate at 2 layers at 30000 weights: -" in told.partition("moves further")[2]
    (section,) = [one for one in found.sections if "else" in one.title]
    tables = {table.label.partition(", ")[2]: table for table in section.tables}
    assert list(tables) == ["1 layer at 300 weights", "2 layers at 300 weights",
                            "2 layers at 30000 weights", "4 layers at 300 weights",
                            "4 layers at 30000 weights", "8 layers at 300 weights",
                            "8 layers at 30000 weights"]  # fmt: skip
    assert {row[0]: row[-2:] for row in tables["2 layers at 30000 weights"].rows}[
        "twice the rate"
    ] == ("no", "no")
    assert "not in twice the rate at 2 layers at 30000 weights." in told
    rows = {row[0]: row for row in tables["8 layers at 300 weights"].rows}
    # each box against the next one towards that of the study
    assert rows["larger box, 27 x 14 for 18 x 9 d"][1] == "4"
    assert rows["smaller box, 12 x 6 for 18 x 9 d"][1] == "7"
    assert "2 ranks" in {row[0] for row in tables["2 layers at 30000 weights"].rows}
    for box in ("16 x 8", "24 x 12"):
        told = f"4 layers at 300 weights, {box} d, rate to zero"
        assert any(told in item for item in section.items)


def test_an_arm_of_two_changes_is_held_against_the_one_in_its_box():
    place = ", 4 layers at 300 weights"
    rows = changed(angles(0.0), f"smaller box{place}", 2.0)
    found = STUDY.conclude(changed(rows, f"twice the rate in the smaller box{place}", 2.0), None)
    (section,) = [one for one in found.sections if "else" in one.title]
    (table,) = [one for one in section.tables if one.label.endswith(place.removeprefix(", "))]
    told = {row[0]: row for row in table.rows}
    assert float(told["smaller box, 16 x 8 for 24 x 12 d"][3]) == pytest.approx(2.0, abs=0.1)
    assert float(told["twice the rate in the smaller box"][3]) == pytest.approx(0.0, abs=0.1)
    assert float(told["half the rate in the smaller box"][3]) == pytest.approx(-2.0, abs=0.1)
    assert float(told["half the rate"][3]) == pytest.approx(0.0, abs=0.1)


def test_softness_is_told_in_every_box_and_rate_that_both_stiffnesses_have():
    moved = "smaller box, 4 layers at 300 weights"
    found = STUDY.conclude(changed(angles(0.5), moved, -1.0), None)
    (softness,) = [one for one in found.sections if one.title == "Softness"]
    told = {row[:3]: row[3:] for row in softness.tables[1].rows}
    assert list(told) == [
        ("4", "16 x 8", "0.1"), ("4", "16 x 8", "0.2"), ("4", "36 x 18", "0.1"),
        ("8", "12 x 6", "0.1"), ("8", "27 x 14", "0.1"),
    ]  # fmt: skip
    assert float(told["4", "16 x 8", "0.1"][0]) == pytest.approx(-1.5, abs=0.1)
    assert float(told["4", "16 x 8", "0.2"][0]) == pytest.approx(-0.5, abs=0.2)
    assert [row[-1] for row in told.values()] == ["depends on softness"] * 5
    assert [row[2] for row in told.values()] == ["12", "4", "5", "7", "3"]
    # three boxes at each stiffness, the smallest of the soft ones moved
    (endless,) = [one for one in found.verdict if "endless box" in one]
    assert "4 layers: " in endless
    assert "8 layers: -0." in endless


@pytest.mark.parametrize(("apart", "overlaps"), [(0.5, True), (0.7, False)])
def test_intervals_overlap_up_to_their_sum(apart, overlaps):
    mean, difference = Mean(10.0 + apart, 0.2, 5), Mean(apart, 0.4, 5)
    assert Change("larger box", mean, difference, own=0.4).overlaps is overlaps


def test_the_two_largest_boxes_say_whether_the_angle_depends_on_the_box():
    smallest = changed(angles(0.0), "smaller box", 1.5)
    assert "smaller box, 16 x 8 for 24 x 12 d at 1 layer at 300 weights: +1." in narrow(smallest)
    assert "d at 1 layer" not in counted(smallest)
    largest = changed(angles(0.0), "larger box", 1.5)
    assert "larger box, 36 x 18 for 24 x 12 d at 1 layer at 300 weights: +1." in counted(largest)
    assert "d at 1 layer" not in narrow(largest)


def counted(rows):
    """Return what the verdict says of changes that count."""
    return " ".join(one for one in STUDY.conclude(rows, None).verdict if "of the arrest" in one)


def narrow(rows):
    """Return what the verdict says of boxes smaller than the two largest."""
    return " ".join(one for one in STUDY.conclude(rows, None).verdict if "In boxes" in one)


def test_what_level_full_costs_follows_from_the_wall_times_of_the_runs():
    rows = angles(0.0)
    assert all("full" not in one.title for one in STUDY.conclude(rows, None).sections)
    timed = {
        name: [
            {**one, "steps": 1000, "wall_time_s": 1e-3 * grains_in(one) * (1 + one["seed"]) / split}
            for one in some
        ]
        for name, some in rows.items()
        for split in [1.6 if name.startswith("2 ranks") else 1.0]
    }
    section = STUDY.conclude(timed, None).sections[-1]
    assert section.title == "What level full would cost"
    # the least is that of seed 1: 2e-3 s for 1000 steps; two ranks lose 20 %
    assert "2.00 us at 288" in section.items[0]
    assert "Efficiency of two ranks: 0.80 at 512" in section.items[1]
    runs = durations_of(STUDY.arms("full"), [Speed(288, 1, 2e-6), Speed(1152, 1, 2e-6)])
    (table,) = section.tables
    assert table.rows[0][:4] == ("1", "1", f"{sum(runs) / 3600:.1f}", f"{sum(runs) / 3600:.0f}")
