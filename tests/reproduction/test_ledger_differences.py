import math

import pandas as pd
import pytest

from harness.reproduction.claims import Ledger, Source, claim, compare, ledger_differences


def ledger(printed=10.21, found=10.2078, key="eq-6", holds=True, width=0.005):
    number = compare(
        Source(key, "eq. (6)", "theta", tolerance=width, unit="deg", why="half the last digit"),
        printed=printed,
        found=found,
        computed=f"{found:.4f} deg",
    )
    words = claim(Source("text-1", "text", "it falls"), holds=holds, computed="it does")
    return Ledger((number, words)).to_frame()


def test_round_off_is_no_difference():
    assert ledger_differences(ledger(), ledger(found=10.2078 * (1 + 1e-7))) == []
    residual = ledger(printed=0.0, found=3e-16, width=1e-12)
    assert ledger_differences(residual, ledger(printed=0.0, found=8e-16, width=1e-12)) == []


@pytest.mark.parametrize(
    ("other", "told"),
    [
        (ledger(found=10.2079), ["eq-6: found was 10.2078, is 10.2079"]),
        (
            ledger(printed=13.87),
            ["eq-6: was reproduced, is not reproduced", "eq-6: printed was 10.21, is 13.87"],
        ),
        (ledger(holds=False), ["text-1: was reproduced, is not reproduced"]),
        (ledger(key="eq-7"), ["eq-6: is not there any more", "eq-7: is new"]),
        (ledger(found=math.nan), ["eq-6: was reproduced, is not reproduced", "eq-6: found"]),
    ],
)
def test_what_changed_is_told(other, told):
    lines = ledger_differences(ledger(), other)
    assert len(lines) == len(told)
    assert all(line.startswith(start) for line, start in zip(lines, told, strict=True))


def test_a_ledger_read_from_its_file_is_the_same(tmp_path):
    frame = ledger()
    frame.to_csv(tmp_path / "ledger.csv", index=False)
    assert ledger_differences(pd.read_csv(tmp_path / "ledger.csv"), frame) == []
