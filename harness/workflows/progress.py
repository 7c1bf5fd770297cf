"""How a long workflow says how far it is."""

from harness.cases.contract import Progress as Progress
from harness.cases.contract import silent as silent
