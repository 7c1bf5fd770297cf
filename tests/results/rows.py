"""A table of rows, changes that are planted in it, and lists of any rows."""
# ruff: noqa: I001

from dataclasses import replace

from hypothesis import strategies as st

from harness.results.rows import (
    NAN, Failure, Kind, Row, Tolerance, Verdict, failed, finding, judge, not_tested, table,
)  # fmt: skip

NARROW = Tolerance(1e-9, 0.0, "round-off of a product")

TEXT = st.text(st.characters(exclude_categories=["Cs"]), max_size=10)
NUMBERS = st.floats(allow_nan=True, allow_infinity=True)
SEVERAL = st.lists(
    st.builds(Row, case=TEXT, setup=TEXT, quantity=TEXT, engine=TEXT, check=TEXT, value=NUMBERS,
              uncertainty=NUMBERS, expected=NUMBERS, tolerance=NUMBERS, note=TEXT, reason=TEXT,
              verdict=st.sampled_from(Verdict), failure=st.sampled_from(Failure)),
    max_size=6, unique_by=lambda one: one.key,
)  # fmt: skip


def row(quantity="angle", value=10.0, **fields):
    """Return a row of the incline that passes."""
    given = {
        "case": "incline", "setup": "plastic", "engine": "code", "version": "1", "unit": "deg",
        "expected": 10.0, "level": "quick", "inputs": "a", "kind": Kind.CROSS_CODE,
    }  # fmt: skip
    return judge(Row(quantity=quantity, value=value, **given | fields), NARROW)


def recorded(quantity, value, tolerance, **fields):
    """Return a row that is held against the accepted run alone."""
    return judge(
        replace(row(quantity, value, **fields), kind=Kind.RECORDED, expected=NAN), tolerance
    )


def rows(*changed):
    """Return a table with one row of each verdict, some replaced by quantity, None for none."""
    standard = [
        row("angle"),
        row("shock", 10.1),
        not_tested(row("path"), "no such contact"),
        recorded("time", 3.0, Tolerance(0.0, 1e-6)),
        replace(finding(row("difference", 0.25)), tolerance=NAN),
        replace(row("torque", 9.0), verdict=Verdict.KNOWN_DEFECT, failure=Failure.NONE,
                defect="weak"),
        failed(row("flight"), Failure.ENGINE, "died: SIGSEGV", "last words"),
        row("steady", level="default"),
    ]  # fmt: skip
    by_name = {one.quantity: one for one in standard} | dict(changed)
    return table(one for one in by_name.values() if one is not None)
