import math

import numpy as np
import pytest

from harness.cases.incline.system import Incline
from harness.errors import RequestError
from harness.parameters.law import CONTACTS, Contact

POSITIVE = "greater than 0"


def growth(zeta, steps_per_contact):
    """Return the spectral radius of one step in the well (m = k = 1), in two dimensions.

    Velocity Verlet whose damping sees the half-step velocity; both contacts
    from their own normals, 30 deg either side of the row's.
    """
    step = math.pi / steps_per_contact
    normals = [np.array([math.sin(a), math.cos(a)]) for a in (math.pi / 6, -math.pi / 6)]
    projector = sum(np.outer(n, n) for n in normals)
    half_step, one = 0.5 * step, np.eye(2)
    # state: position, velocity, force of the last evaluation
    kick = np.block(
        [
            [one, 0 * one, 0 * one],
            [0 * one, one, half_step * one],
            [0 * one, 0 * one, one],
        ]
    )
    drift = np.block([[one, step * one, 0 * one], [0 * one, one, 0 * one], [0 * one, 0 * one, one]])
    force = np.block(
        [
            [one, 0 * one, 0 * one],
            [0 * one, one, 0 * one],
            [-projector, -2 * zeta * projector, 0 * one],
        ]
    )
    return max(abs(np.linalg.eigvals(kick @ force @ drift @ kick)))


def bisected_bound(zeta):
    """Return the steps per contact at which a step stops growing in the well."""
    low, high = 0.1, 1000.0
    assert growth(zeta, low) > 1.0 >= growth(zeta, high) - 1e-9
    for _ in range(60):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if growth(zeta, middle) > 1.0 + 1e-9 else (low, middle)
    return high


@pytest.mark.parametrize("zeta", [0.01, 0.3, 0.99768, 1.0, 2.0, 5.0, 20.0])
def test_stability_bound_against_the_spectral_radius_of_a_step(zeta):
    case = Incline(contact=Contact(damping_ratio=zeta), steps_per_contact=500.0)
    assert case.fewest_steps_per_contact == pytest.approx(bisected_bound(zeta), rel=1e-6)


def test_stability_bound_counts_the_damping_that_half_the_mass_really_gives():
    half = Incline(contact=Contact(damping_ratio=5.0, effective_mass="half"), steps_per_contact=90)
    assert half.fewest_steps_per_contact == pytest.approx(
        bisected_bound(5.0 / math.sqrt(2)), rel=1e-6
    )


@pytest.mark.parametrize("contact", CONTACTS.values(), ids=CONTACTS)
def test_step_at_the_bound_is_refused_and_just_above_it_is_taken(contact):
    bound = Incline(contact=contact, steps_per_contact=100.0).fewest_steps_per_contact
    Incline(contact=contact, steps_per_contact=bound * (1 + 1e-12))
    with pytest.raises(
        RequestError, match=r"^steps_per_contact = \S+ is unstable .*must be greater than \d"
    ):
        Incline(contact=contact, steps_per_contact=bound)


@pytest.mark.parametrize(
    ("field", "value", "unit", "allowed"),
    [
        ("angle", 30.1, " deg", "greater than or equal to 0 and less than or equal to 30"),
        ("angle", -0.1, " deg", "greater than or equal to 0 and less than or equal to 30"),
        ("angle", math.nan, " deg", "greater than or equal to 0 and less than or equal to 30"),
        ("angle", math.inf, " deg", "greater than or equal to 0 and less than or equal to 30"),
        *(
            (field, value, unit, POSITIVE)
            for field, unit in (
                ("stiffness", " N/m"),
                ("diameter", " m"),
                ("density", " kg/m3"),
                ("gravity", " m/s2"),
                ("time_limit", ""),
            )
            for value in (0.0, -1.0, math.nan, math.inf, -math.inf)
        ),
        ("steps_per_contact", 0.0, "", "greater than 0 and less than or equal to 100000"),
        ("steps_per_contact", math.nan, "", "greater than 0 and less than or equal to 100000"),
        ("spheres", 3, "", "greater than or equal to 4 and less than or equal to 100000"),
        ("wells", 0, "", "greater than or equal to 1 and less than or equal to 10000"),
        ("phase", 1.5, "", "greater than or equal to 0 and less than or equal to 1"),
    ],
)
def test_bad_input_is_one_line_with_name_value_unit_and_range(field, value, unit, allowed):
    with pytest.raises(RequestError) as caught:
        Incline(**{field: value})
    finite = "" if math.isfinite(value) else "a finite number, "
    assert str(caught.value) == f"{field} = {value!r}{unit}: must be {finite}{allowed}"
    assert caught.value.exit_status == 2


def test_stiffness_too_soft_to_bear_the_grain_is_named_with_the_least_allowed():
    least = 100 * 9.81
    with pytest.raises(RequestError, match=rf"^stiffness = 900 N/m .*at least {least:.0f} N/m"):
        Incline(stiffness=900.0)
    assert Incline(stiffness=least * (1 + 1e-12)).static_overlap == pytest.approx(0.01)


@pytest.mark.parametrize("diameter", [1e-150, 1e150])
def test_mass_beyond_floating_point_is_refused(diameter):
    with pytest.raises(RequestError, match="diameter"):
        Incline(diameter=diameter)


def test_units_of_the_source_make_a_grain_of_one_kilogram():
    case = Incline()
    assert case.mass == pytest.approx(1.0, rel=1e-14)
    assert case.weight_energy == pytest.approx(9.81, rel=1e-14)
    assert case.contact_time == pytest.approx(math.pi / 1000, rel=1e-14)
