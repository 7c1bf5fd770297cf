"""Names of :mod:`harness.model.allowed` for modules that have not moved."""

from harness.model.allowed import COUNT as COUNT
from harness.model.allowed import Allowed as Allowed
from harness.model.allowed import allowed_in as allowed_in
from harness.model.allowed import unit_in as unit_in
