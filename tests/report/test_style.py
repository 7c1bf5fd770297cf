import pytest

from harness.report.style import power


@pytest.mark.parametrize(
    ("value", "said"),
    [(1e6, "1e6"), (10**5.5, "3.2e5"), (3e7, "3e7"), (1e-4, "1e-4"), (1.0, "1e0"), (9.99e5, "1e6")],
)
def test_powers_of_ten_are_short(value, said):
    assert power(value) == said
