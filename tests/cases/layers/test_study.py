"""The study of layers: what is run, intervals that cover, the test of softness, the fit."""

import json
import math
from collections import Counter
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy import stats

from harness.cases.incline.system import Incline
from harness.cases.layers.averages import (
    BOX_POWERS,
    Mean,
    covering,
    fit_over_thickness,
    limit_of,
    mean_of,
    paired_difference,
    welch,
    with_scatter_of,
)
from harness.cases.layers.case import CASE
from harness.cases.layers.changes import TEST, compared, seeds_of
from harness.cases.layers.extents import (
    BOXES,
    EXTENTS,
    LIMIT,
    RANKS,
    REFERENCE,
    SINGLE_CRITICAL_DEG,
    THICKNESS,
    Speed,
    durations_of,
    grains_in,
    steps_of,
)
from harness.cases.layers.study import LayersStudy
from harness.cases.layers.system import SINGLE
from harness.cases.source_angles import READINGS, source_angles
from harness.errors import RequestError
from harness.observables.reference import ReferencePoints
from harness.parameters.base import Parameters
from harness.report.style import house_style
from harness.workflows import critical_angle
from harness.workflows.sweep_plan import column_of

STUDY = LayersStudy()
REPORT = Path(__file__).parents[3] / "reports/layers"
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


ARMS = STUDY.arms("default")


def test_the_interval_is_that_of_student():
    values = [9.0, 9.2, 9.1, 9.5]
    mean = mean_of(values)
    # t of three degrees of freedom at 97.5 %: 3.182446
    student = 3.182446 * np.std(values, ddof=1) / 2
    assert (mean.value, mean.half_width) == (pytest.approx(9.2), pytest.approx(student, rel=1e-6))
    assert (mean.count, mean.freedom, mean.scatter) == (4, 3, pytest.approx(0.216, abs=1e-3))
    assert math.isnan(mean_of([9.0]).half_width)
    assert math.isnan(mean_of([]).value)


def test_intervals_cover_the_mean_as_often_as_they_say():
    """Of 400 samples of four the 95 % interval misses some twenty, with a spread of four."""
    rng = np.random.default_rng(1)
    samples = (mean_of(rng.normal(5.0, 0.3, 4)) for _ in range(400))
    missed = sum(not one.low <= 5.0 <= one.high for one in samples)
    assert abs(missed - 20) <= 3 * math.sqrt(400 * 0.05 * 0.95)


@pytest.mark.parametrize("scatter", [0.2, 0.3, 0.5, 0.6])
def test_seeds_added_until_the_interval_is_narrow_leave_it_a_little_too_narrow(scatter):
    """The rule of the means over the thickness, from 3 to 14 seeds: 90 to 95 %, no bias."""
    rows, counts = 20000, np.arange(1, 15)
    values = np.random.default_rng(0).normal(0.0, scatter, (rows, counts[-1]))
    means = np.cumsum(values, axis=1) / counts
    squares = np.cumsum(values**2, axis=1) - counts * means**2
    degrees = np.maximum(counts - 1, 1)
    half = stats.t.ppf(0.975, degrees) * np.sqrt(np.maximum(squares, 0.0) / degrees / counts)
    enough = (half < 0.3) & (counts >= 3)
    enough[:, -1] = True
    end = np.arange(rows), enough.argmax(axis=1)
    assert 0.90 < np.mean(np.abs(means[end]) <= half[end]) < 0.955
    assert abs(means[end].mean()) < 4.0 * means[end].std() / math.sqrt(rows)


@given(
    st.lists(st.floats(-5.0, 5.0), min_size=3, max_size=12, unique=True),
    st.lists(st.floats(-5.0, 5.0), min_size=3, max_size=12, unique=True),
)
def test_independent_differences_are_those_of_welch(one, other):
    assume(np.ptp(one) > 1e-3 and np.ptp(other) > 1e-3)
    difference = welch(mean_of(one), mean_of(other))
    scipys = stats.ttest_ind(one, other, equal_var=False).confidence_interval(0.95)
    assert difference.low == pytest.approx(scipys.low, abs=1e-7)
    assert difference.high == pytest.approx(scipys.high, abs=1e-7)


def test_pairing_takes_the_seeds_that_both_have():
    one, other = {1: 9.0, 2: 9.5, 3: 8.0}, {2: 9.0, 3: 7.6, 4: 1.0}
    difference = paired_difference(one, other)
    assert (difference.value, difference.count) == (pytest.approx(0.45), 2)
    scipys = stats.ttest_rel([9.5, 8.0], [9.0, 7.6]).confidence_interval(0.95)
    assert (difference.low, difference.high) == pytest.approx((scipys.low, scipys.high))
    assert welch(mean_of([1.0, 1.0]), mean_of([2.0, 2.0])).half_width == 0.0
    assert welch(mean_of([1.0, 2.0]), mean_of([2.0])).word == "undecided"


@pytest.mark.parametrize(
    ("difference", "word"),
    [
        (Mean(0.1, 0.15, 4), "the same"),
        (Mean(0.2, 0.05, 4), "the same"),
        (Mean(0.2, 0.15, 4), "differs"),
        (Mean(-0.6, 0.2, 4), "differs"),
        (Mean(0.4, 0.2, 4), "differs"),
        (Mean(0.1, 0.5, 4), "undecided"),
        (Mean(0.0, 0.94, 4), "undecided"),
        (Mean(0.4, math.nan, 1), "undecided"),
    ],
)
def test_the_word_follows_from_interval_and_margin(difference, word):
    assert difference.word == word


@pytest.mark.parametrize("paired", [True, False])
def test_a_change_of_a_known_size_differs_and_noise_does_not(paired):
    """Of 300 worlds of eight seeds: noise differs in some 5 % at most, 1 deg always."""
    rng = np.random.default_rng(7)

    def words(shift, scatter=0.25):
        for _ in range(300):
            base = rng.normal(0.0, 0.2, 8) if paired else 0.0
            one, other = (rng.normal(0.0, scatter, 8) + base for _ in range(2))
            if paired:
                seeds = [dict(enumerate(x)) for x in (one + shift, other)]
                yield paired_difference(*seeds).word
            else:
                yield welch(mean_of(one + shift), mean_of(other)).word

    noise, moved, narrow = (Counter(words(*given)) for given in ((0.0,), (1.0,), (0.0, 0.05)))
    assert noise["differs"] <= 15 + 3 * math.sqrt(15)
    assert moved["differs"] >= 297
    assert moved["the same"] == 0
    assert narrow["the same"] >= 297


def law_of(amplitude, exponent, noise, rng):
    return {
        h: mean_of(5.76 + amplitude * h**-exponent + rng.normal(0.0, noise, 6))
        for h in (1, 2, 4, 8, 12, 20)
    }


def test_the_fit_finds_the_law_that_it_was_given():
    """With noise of 0.05 deg its intervals hold the limit and the exponent of the law."""
    fit = fit_over_thickness(law_of(8.0, 0.7, 0.05, np.random.default_rng(3)))
    assert fit.limit.low < 5.76 < fit.limit.high
    assert fit.exponent.low < 0.7 < fit.exponent.high
    exact = fit_over_thickness(law_of(8.0, 0.7, 0.0, np.random.default_rng(3)))
    assert (exact.limit.value, exact.exponent.value) == pytest.approx((5.76, 0.7), abs=1e-3)
    assert exact.curve(np.array([4.0]))[0] == pytest.approx(5.76 + 8.0 * 4**-0.7, abs=1e-4)
    with pytest.raises(RequestError, match="needs five thicknesses, 4 are there"):
        fit_over_thickness(dict.fromkeys((1, 2, 4, 8), Mean(9.0, 0.1, 4)))


def test_a_law_over_the_thickness_is_fitted_within_equal_boxes_only():
    assert len({box[:2] for box in BOXES.values()}) > 1
    thickness = STUDY.conclude(angles(0.0), None).sections[0]
    assert any("No law is fitted over the thickness" in item for item in thickness.items)
    assert len({box[:2] for box in EXTENTS["full"].boxes.values()}) == 1
    thickness = STUDY.conclude(angles(0.0, "full"), None).sections[0]
    limits = [item.partition("theta_inf = ")[2][:4] for item in thickness.items[:4]]
    assert [float(one) for one in limits] == pytest.approx([5.0] * 4, abs=0.2)


LENGTHS = (16.0, 24.0, 36.0, 72.0)


def boxes_of(power, error, lengths=LENGTHS):
    """Return means by 1/length of a world whose angle is 7 + 25 (10/length)^power / 10^power."""
    slope = (8.6 - 7.0) * 16.0**power
    return {1.0 / one: Mean(7.0 + slope * one**-power, error, 8) for one in lengths}


@pytest.mark.parametrize("power", BOX_POWERS)
def test_of_models_of_the_box_the_right_one_is_kept_and_a_wrong_one_is_not(power):
    limit = limit_of(boxes_of(power, 0.05), BOX_POWERS)
    assert [one.power for one in limit.kept] == [power]
    assert limit.mean.value == pytest.approx(7.0)
    assert next(one for one in limit.models if one.power == power).chance == pytest.approx(1.0)


def test_the_distance_between_models_is_in_the_uncertainty_of_a_limit():
    limit = limit_of(boxes_of(1.0, 0.3, LENGTHS[:3]), BOX_POWERS)
    assert limit.kept == limit.models
    values = [one.limit.value for one in limit.models]
    assert limit.mean.low == min(one.limit.low for one in limit.models)
    assert limit.mean.half_width > limit.models[0].limit.half_width
    assert limit.mean.low < min(values) < max(values) < limit.mean.high
    assert limit.mean == covering([one.limit for one in limit.models])
    with pytest.raises(RequestError, match="needs three values, 2 are there"):
        limit_of({0.1: Mean(1.0, 0.1, 4), 0.2: Mean(1.0, 0.1, 4)}, BOX_POWERS)


def test_a_limit_has_the_variance_of_the_intercept_of_a_line():
    x = (0.025, 0.05, 0.1)
    (model,) = limit_of({one: Mean(9.0 + 4.0 * one, 0.1, 4) for one in x}, (1.0,)).models
    assert (model.limit.value, model.slope) == pytest.approx((9.0, 4.0))
    # sigma^2 sum x^2 / (n sum x^2 - (sum x)^2)
    squares, total = sum(one**2 for one in x), sum(x)
    half = 0.1 * math.sqrt(squares / (3 * squares - total**2))
    assert model.limit.half_width == pytest.approx(half)


def test_a_box_of_few_seeds_takes_the_scatter_of_the_smaller_one():
    smaller = mean_of([7.5, 7.6, 7.7, 7.6, 7.5])
    alone = with_scatter_of(mean_of([7.4]), smaller)
    assert alone.half_width == pytest.approx(stats.t.ppf(0.975, 4) * smaller.scatter)
    assert welch(alone, smaller).freedom != 0
    pair = with_scatter_of(mean_of([7.40, 7.41]), smaller)
    assert pair.half_width == pytest.approx(alone.half_width / math.sqrt(2.0))
    wide = mean_of([7.0, 8.0])
    assert with_scatter_of(wide, smaller) == wide
    many = mean_of([7.4, 7.41, 7.4, 7.41])
    assert with_scatter_of(many, smaller) == many


@pytest.mark.slow
def test_the_critical_angle_at_the_step_of_the_single_grain_is_that_of_the_reference():
    weight = Incline()
    grain = Incline(
        contact=SINGLE.contact,
        stiffness=SINGLE.stiffness_over_weight * weight.mass * weight.gravity / weight.diameter,
        steps_per_contact=SINGLE.steps_per_contact,
    )
    angle, error = SINGLE_CRITICAL_DEG
    steady = critical_angle(grain, method="steady", tolerance_deg=1e-3, engine="reference")
    assert steady.value_deg == pytest.approx(angle, abs=error)
    fine = grain.replace(steps_per_contact=1000.0)
    assert critical_angle(fine, engine="reference").value_deg == pytest.approx(10.204, abs=5e-4)


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
    told = {column_of(name, units.get(name, "")): value for name, value in values.items()}
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


def angles(softness, level="default"):
    """Return the rows of a level in a world where softness lowers angles by so much."""
    rng = np.random.default_rng(0)
    rows, stops = {}, {}
    for arm in ARMS if level == "default" else STUDY.arms(level):
        if arm.name == LIMIT:
            rows[arm.name] = [row(one, 1, 10.2 - one.rate / 2) for one in arm.parameters]
            continue
        rows[arm.name] = []
        for one in arm.parameters:
            angle = 5.0 + 8.0 / one.layers + 0.05 * rng.normal()
            angle -= softness * (one.stiffness_over_weight < 1e3)
            # a run that stands in two arms is one run, and so is it up to its stop if it is raised
            angle = stops.setdefault((one.replace(rise=0.0), arm.ranks), angle)
            rows[arm.name].append(row(one, arm.ranks, angle))
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
    assert "One test judges every difference" in found.test == TEST
    assert all(set(one) >= KEYS for one in found.rows)
    assert {one["arm"] for one in found.rows} == {arm.name for arm in ARMS}
    thick = [one for one in found.rows if one["arm"] == THICKNESS]
    # one more soft seed of 36 x 18 d at one layer is among the runs that change the box
    assert {key_of_row(one): one["seeds"] for one in thick} == {**SEEDS, (1, 300.0): 8}
    titles = [section.title for section in found.sections]
    assert titles == ["Thickness", "Softness", "What else could move the angle",
                      "Limits of box and rate", "Start, and other definitions of the stop",
                      "The limit of a single grain"]  # fmt: skip
    with house_style():
        drawing, boxes = [one for section in found.sections for one in section.drawings]
        (axes,), (over_box,) = drawing.draw().axes, boxes.draw().axes
    assert over_box.get_legend_handles_labels()[1] == PLACES
    # models up to the largest 1/length where there are three boxes
    ends = {line.get_xdata()[-1] for line in over_box.lines if len(line.get_xdata()) == 50}
    assert ends == {1 / 16, 1 / 12}
    labels = " ".join(axes.get_legend_handles_labels()[1])
    assert all(word in labels for word in ("lost", "kept", "10.2078", "Peyneau", "mine.csv"))


PLACES = ["1 layer at 300 weights", "2 layers at 300 weights", "2 layers at 30000 weights",
          "4 layers at 300 weights", "4 layers at 30000 weights", "8 layers at 300 weights",
          "8 layers at 30000 weights"]  # fmt: skip


def test_undecided_runs_are_told_and_are_no_angles():
    rows = angles(0.0)
    more = [f"{name}, 8 layers at 300 weights" for name in ("raised again", "2 ranks")]
    for name in (THICKNESS, *more):
        rows[name] = [{**one, "stop_angle_deg": None} if one["layers"] == 8 else one
                      for one in rows[name]]  # fmt: skip
    rows["2 ranks"] = []
    found = STUDY.conclude(rows, None)
    lost = {key: count for key, count in SEEDS.items() if key[0] == 8}
    total = sum(lost.values()) + sum(len(rows[name]) for name in more)
    told = f"Without an angle: {total} runs"
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


def changes_in(rows):
    """Return the changes by place and name."""
    return {(one.place, one.name): one for some in compared(rows) for one in some.changes}


def sentence(rows, words):
    (said,) = [one for one in STUDY.conclude(rows, None).verdict if one.startswith(words)]
    return said


SOFT2, STIFF2, SOFT4 = PLACES[1], PLACES[2], PLACES[3]


def test_a_world_without_any_change_has_none_that_differs_beyond_the_margin():
    changes = changes_in(angles(0.0))
    assert {place for place, _ in changes} == set(PLACES)
    assert all(abs(one.difference.value) < 0.2 for one in changes.values())
    words = Counter(one.word for one in changes.values())
    assert words["differs"] == 0
    assert words["the same"] > 0.9 * len(changes)


@pytest.mark.parametrize(
    ("arm", "name", "by", "word"),
    [
        ("twice the rate, 2 layers at 30000 weights", "twice the rate, 20 x 10 d", -1.0, "differs"),
        ("half the rate, 4 layers at 300 weights", "half the rate, 24 x 12 d", 0.6, "differs"),
        ("twice the rate, 2 layers at 30000 weights", "twice the rate, 20 x 10 d", 0.0, "the same"),
    ],
)
def test_a_planted_change_is_found_where_it_is_and_nowhere_else(arm, name, by, word):
    rows = changed(angles(0.0), arm, by)
    changes = changes_in(rows)
    place = arm.partition(", ")[2]
    assert changes[place, name].word == word
    assert changes[place, name].difference.value == pytest.approx(by, abs=0.15)
    assert [one.name for one in changes.values() if one.word == "differs"] == (
        [name] if word == "differs" else []
    )
    said = sentence(rows, "Another rate, step")
    assert (f"{name} at {place}: " in said) is (word == "differs")
    split = changes_in(changed(rows, "2 ranks, 2 layers at 30000 weights", 0.8))
    assert split[STIFF2, "2 ranks, 20 x 10 d"].word == "differs"


def test_noise_in_an_arm_is_undecided_and_is_not_counted_as_the_same():
    arm, rows = "twice the rate, 2 layers at 30000 weights", angles(0.0)
    for one, by in zip(rows[arm], (0.9, -0.9, 0.8, -0.8), strict=True):
        one["stop_angle_deg"] += by
    assert changes_in(rows)[STIFF2, "twice the rate, 20 x 10 d"].word == "undecided"
    said, quiet = sentence(rows, "Another rate"), sentence(angles(0.0), "Another rate")
    assert "1 undecided. The undecided have half widths of " in said
    assert "0 undecided" in quiet


def test_a_box_is_held_against_the_next_smaller_one():
    changes = changes_in(changed(angles(0.0), f"largest box, {SOFT4}", -0.5))
    boxes = [one.name for one in changes.values() if (one.place, one.kind) == (SOFT4, "box")]
    assert boxes == ["24 x 12 for 16 x 8 d", "36 x 18 for 24 x 12 d", "72 x 36 for 36 x 18 d"]
    assert changes[SOFT4, boxes[-1]].word == "differs"
    assert changes[SOFT4, boxes[0]].word == "the same"


def test_an_arm_of_two_changes_is_held_against_the_one_in_its_box():
    rows = changed(angles(0.0), f"smaller box, {SOFT4}", 2.0)
    changes = changes_in(changed(rows, f"twice the rate in the smaller box, {SOFT4}", 2.0))
    values = {name: one.difference.value for (place, name), one in changes.items()
              if place == SOFT4}  # fmt: skip
    # of four seeds the runs on two ranks, which are not moved, are averaged in
    assert values["24 x 12 for 16 x 8 d"] == pytest.approx(-2.0 + 4 / 14, abs=0.1)
    assert values["twice the rate, 16 x 8 d"] == pytest.approx(0.5, abs=0.1)
    assert values["2 ranks, 16 x 8 d"] == pytest.approx(-2.0, abs=0.1)
    assert values["half the rate, 24 x 12 d"] == pytest.approx(0.0, abs=0.1)


def test_runs_of_one_system_on_other_ranks_are_averaged_seed_by_seed():
    rows = changed(angles(0.0), "2 ranks, 2 layers at 30000 weights", 0.4)
    plain, moved = (
        next(one for one in STUDY.conclude(some, None).rows
             if one["arm"] == THICKNESS and key_of_row(one) == (2, 3e4))
        for some in (angles(0.0), rows)
    )  # fmt: skip
    assert moved["seeds"] == plain["seeds"] == 8
    # four of eight seeds, half of their runs
    assert moved["stop_angle_deg"] - plain["stop_angle_deg"] == pytest.approx(0.1)
    assert moved["uncertainty_deg"] > plain["uncertainty_deg"]
    one = {"seed": 1, "ranks": 1, "stop_angle_deg": 9.0}
    assert seeds_of([one, one, {**one, "ranks": 2, "stop_angle_deg": 10.0}]) == {1: 9.5}


def test_runs_against_themselves_are_no_changes():
    places = compared(angles(0.0))
    assert not [one for some in places for one in some.changes if "arrest" in one.name]
    assert not [one for some in places for one in some.changes if "raised" in one.name]
    own = sentence(angles(0.0), "Other definitions of the arrest")
    assert "are no changes of their own: 14 of 14 the same" in own
    starts = {some.place: one.difference for some in places for one in some.starts}
    assert set(starts) == {PLACES[0], PLACES[3], PLACES[5]}
    assert all(one.value == pytest.approx(1.2) for one in starts.values())
    assert all(one.word == "differs" for one in starts.values())
    assert "start minus stop of the same runs" in sentence(angles(0.0), "Hysteresis")


def test_softness_is_said_in_every_box_and_rate_that_both_stiffnesses_have():
    moved = f"smaller box, {SOFT4}"
    found = STUDY.conclude(changed(angles(0.5), moved, -1.0), None)
    (softness,) = [one for one in found.sections if one.title == "Softness"]
    lines = {row[:3]: row[3:] for row in softness.tables[1].rows}
    assert list(lines) == [
        ("4", "16 x 8", "0.1"), ("4", "16 x 8", "0.2"), ("4", "36 x 18", "0.1"),
        ("8", "12 x 6", "0.1"), ("8", "27 x 14", "0.1"),
    ]  # fmt: skip
    # of four pairs the soft run on two ranks is averaged in
    assert float(lines["4", "16 x 8", "0.1"][0]) == pytest.approx(-1.5 + 2 / 12, abs=0.1)
    assert float(lines["4", "16 x 8", "0.2"][0]) == pytest.approx(-0.5, abs=0.2)
    assert [row[-1] for row in lines.values()] == ["differs"] * 5
    assert [row[2] for row in lines.values()] == ["12", "4", "5", "7", "3"]
    said = sentence(angles(0.5), "Softness in an endless box")
    assert "4 layers: -0." in said
    assert "8 layers: -0." in said


def test_limits_stand_with_every_model_of_box_and_rate():
    (section,) = [
        one for one in STUDY.conclude(angles(0.0), None).sections if one.title.startswith("Limits")
    ]
    rows = [row for row in section.tables[0].rows if row[0] == f"{SOFT4}, endless box"]
    assert [row[2] for row in rows] == [
        "1/length^1", "1/length^2", "1/length^3", "all that count"
    ]  # fmt: skip
    assert rows[0][1] == "16, 24, 36, 72 d"
    assert {row[0] for row in section.tables[0].rows if "slow" in row[0]} == {
        f"{SOFT4}, 16 x 8 d, slow", f"{SOFT4}, 24 x 12 d, slow", f"{PLACES[5]}, 18 x 9 d, slow"
    }  # fmt: skip


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
    assert section.title == "Cost"
    runs = {
        (one.replace(rise=0.0), arm.ranks, one.rise)
        for arm in ARMS for one in arm.parameters
    }  # fmt: skip
    assert section.items[0].startswith(f"The {len(runs)} different runs of this page took ")
    # the least is that of seed 1: 2e-3 s for 1000 steps; runs on two ranks tell nothing
    assert "2.00 us at 288" in section.items[1]
    runs = durations_of(STUDY.arms("full"), [Speed(288, 1, 2e-6), Speed(1152, 1, 2e-6)])
    (table,) = section.tables
    hours = f"{sum(runs) / 3600:.1f}"
    assert table.rows[0][:3] == ("1", hours, f"{sum(runs) / 3600:.0f}")
    # the command says the same of the same runs
    every = [one for some in timed.values() for one in some]
    cost = STUDY.cost("full", engine_of=None, runs=every)
    assert f"{cost.rows[0]['wall_time_h']:.1f}" == hours


def test_the_committed_verdict_follows_from_the_committed_runs():
    runs = pd.read_csv(REPORT / "runs.csv").astype(object)
    runs = runs.where(runs.notna(), None)
    arms = {str(name): some.to_dict("records") for name, some in runs.groupby("arm", sort=False)}
    committed = json.loads((REPORT / "study.json").read_text(encoding="utf-8"))
    found = STUDY.conclude(arms, None)
    assert list(found.verdict) == committed["verdict"]
    assert found.test == committed["test"]
    assert {arm.name: len(arm.parameters) for arm in STUDY.arms("default")} == {
        name: len(rows) for name, rows in arms.items()
    }


def test_the_model_of_a_run_is_that_of_the_committed_runs():
    """Steps of all runs that the page stands on, by the model, are within a fifth of theirs."""
    runs = pd.read_csv(REPORT / "runs.csv")
    arms = {arm.name: arm for arm in STUDY.arms("default")}
    expected = sum(steps_of(one) for name in runs["arm"].unique() if name != LIMIT
                   for one in arms[name].parameters)  # fmt: skip
    taken = runs[runs["arm"] != LIMIT]["steps"].sum()
    assert expected == pytest.approx(taken, rel=0.2)
