"""A run with rows of every verdict, and sections of a case that is made up."""
# ruff: noqa: I001

from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pandas as pd
import pytest

from harness.report import figures
from harness.report.content import Drawing, Opening, Section, Table
from harness.results.rows import (
    Failure, Kind, Row, Tolerance, Verdict, failed, finding, judge, not_tested, table,
)  # fmt: skip
from harness.store.runs import Meta, Run

HOSTILE = "<script>alert(1)</script> ![x](http://h/x.png) | `a` \x1b[31mred\x07 @you"
WIDTH = Tolerance(3e-4, reason="the last correction of the ladder")
ANGLE = Row(case="slope", setup="plastic, 50 steps", quantity="critical_angle", engine="toy",
            version="1", unit="deg", value=10.2069, uncertainty=4e-5, expected=10.207)  # fmt: skip
DEFECTS = {
    "walls-without-friction": {
        "engine": "toy", "cause": "walls have no friction", "since": "2023",
        "upstream": "issue 12", "script": "reports/defects/walls-without-friction/in.toy",
    }
}  # fmt: skip
SKETCH = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9"><circle r="4"/></svg>'


def rows():
    off = judge(replace(ANGLE, setup="clipped | 50 steps", value=10.3), WIDTH)
    defect = judge(replace(ANGLE, setup="wall", value=9.0, kind=Kind.CROSS_CODE), WIDTH)
    other = replace(ANGLE, engine="other", version="2", kind=Kind.CROSS_CODE)
    log = "# other -in slope.in\nStep 1 <&> 2\nERROR: lost atoms\n"
    return [
        judge(ANGLE, WIDTH),
        off,
        replace(defect, verdict=Verdict.KNOWN_DEFECT, defect="walls-without-friction"),
        failed(replace(other, setup="hangs"), Failure.TIMEOUT, "after 5 s", log),
        not_tested(replace(other, setup="wall"), "its walls mix no materials"),
        not_tested(replace(other, setup=HOSTILE), HOSTILE),
        judge(other, WIDTH),
        finding(replace(ANGLE, quantity="laws", check="clipped against plastic", note="expected")),
        judge(replace(ANGLE, quantity="steps", kind=Kind.RECORDED, expected=np.nan), WIDTH),
    ]


class Page(HTMLParser):
    """The tags of a page with their attributes, and its text."""

    def __init__(self, html):
        super().__init__()
        self.tags, self.words = [], []
        self.feed(html)
        self.text = " ".join(" ".join(self.words).split())

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data):
        if self.tags and self.tags[-1][0] not in ("style", "script"):
            self.words.append(data)

    def values(self, *names):
        """Return the values of attributes of these names that are not empty."""
        every = [attributes.get(name) for _, attributes in self.tags for name in names]
        return [value for value in every if value]


def convergence():
    figure = figures.panels(1, 1)
    steps = np.logspace(-5, -2, 7)
    figure.axes[0].loglog(steps, steps, figures.MARKERS[0], label="LAMMPS")
    figures.label(figure.axes[0], figures.axis("time step", "s"), figures.axis("error", "deg"))
    figures.legend_below(figure)
    figure.text(0.5, 0.5, "theory: 10.20782 deg, 7.0 to 0.00012")
    return figure


def broken():
    raise ZeroDivisionError("no rows")


@pytest.fixture(scope="session")
def run():
    frame = table(rows())
    accepted = frame.assign(value=frame["value"] * ([1.0] * 8 + [0.5]))
    meta = Meta(level="quick", cases=("slope",), engines={"toy": "1", "other": "2"}, seconds=1.5,
                started="2030-01-01T00:00:00+00:00", platform="a test",
                harness_version="0")  # fmt: skip
    scripts, logs = {"slope.in": "run 0\n"}, {"slope.in": "Total wall time: 0:00:01\n"}
    return Run(frame, meta, scripts=scripts, logs=logs).against(accepted)


@pytest.fixture(scope="session")
def sections():
    opening = Opening(
        "At what angle does a grain keep moving?",
        SKETCH,
        ("A quarter of the energy is left.", "It repeats itself.", "So θ_c = 10.2 deg."),
        "Harper and others (2024).",
        (("well", "where the grain touches two spheres"),),
        figure=Drawing("angle", "The angle", "Over the step.", convergence),
    )
    angles = pd.DataFrame({"contact": ["plastic", HOSTILE], "angle (deg)": [10.2, np.nan],
                           "verdict": ["pass", "known defect"]})  # fmt: skip
    drawings = (
        Drawing("angle", "The angle again", "Over the step.", convergence),
        Drawing("bad", "A broken figure", "", broken),
    )
    text = "Contacts with **damping**.\n\n<img src=http://h/x.png>"
    return [Section("The contacts", text, (Table("Angles", angles, "By contact."),), drawings,
                    opening)]  # fmt: skip
