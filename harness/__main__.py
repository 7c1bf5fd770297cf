"""Run the command line by ``python -m harness``."""

from harness.cli import main

main()
