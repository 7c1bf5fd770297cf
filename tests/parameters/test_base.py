from typing import Annotated

import pytest
from pydantic import Field, ValidationError

from harness.errors import RequestError
from harness.parameters.base import Parameters


class Plate(Parameters):
    width: float = Field(1.0, gt=0.0, le=5.0, description="[m] width")
    holes: int = Field(3, ge=0, description="[-] number of holes")
    tilt: float = Field(0.0, description="[deg] tilt")
    layers: tuple[Annotated[float, Field(gt=0.0)], ...] = Field((1.0,), description="[mm] layers")
    label: str = Field("plate", description="free text")


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"width": -2.0}, "width = -2.0 m: must be greater than 0 and less than or equal to 5"),
        ({"width": 6.0}, "width = 6.0 m: must be greater than 0 and less than or equal to 5"),
        (
            {"width": float("nan")},
            "width = nan m: must be a finite number, greater than 0 and less than or equal to 5",
        ),
        (
            {"width": float("inf")},
            "width = inf m: must be a finite number, greater than 0 and less than or equal to 5",
        ),
        ({"holes": -1}, "holes = -1: must be greater than or equal to 0"),
        ({"tilt": float("nan")}, "tilt = nan deg: must be a finite number"),
        ({"layers": (1.0, -3.0)}, "layers = -3.0 mm: must be greater than 0"),
        ({"label": 3}, "label = 3: must be a valid string"),
    ],
)
def test_error_names_field_value_unit_and_whole_range(values, message):
    with pytest.raises(RequestError) as caught:
        Plate(**values)
    assert str(caught.value) == message


def test_value_of_another_kind_is_refused_with_its_name():
    with pytest.raises(RequestError, match=r"^width = 'wide' m: must be a valid number"):
        Plate(width="wide")


def test_unknown_parameter_is_refused_with_the_names_that_exist():
    with pytest.raises(RequestError, match=r"^depth: no such parameter of Plate .*width, holes"):
        Plate(depth=1.0)


def test_parameters_cannot_be_changed():
    plate = Plate()
    with pytest.raises(ValidationError, match="frozen"):
        plate.width = 2.0
    assert plate.width == 1.0


def test_replace_changes_one_value_and_keeps_the_rest():
    plate = Plate(width=2.0, holes=7)
    assert plate.replace(width=3.0) == Plate(width=3.0, holes=7)
    assert plate.width == 2.0


def test_replace_validates_again():
    with pytest.raises(RequestError, match="width"):
        Plate().replace(width=-1.0)
