"""``python -m harness`` is ``dem-harness``."""

from harness.cli import main

main()
