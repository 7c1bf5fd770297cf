"""The scripts that show known defects, as files of a report."""

from __future__ import annotations

from harness.comparison.known_defects import KnownDefect
from harness.comparison.verification import Verification
from harness.report.plain import safe_path

FOLDER = "defects"


def address(defect: KnownDefect) -> str:
    """Return the file of a defect's script below a report."""
    return f"{FOLDER}/{safe_path(defect.name)}/{safe_path(defect.script.rpartition('/')[2])}"


def defect_scripts(found: Verification) -> dict[str, str]:
    """Return the scripts of the defects that checks are marked with, by their files."""
    return {address(defect): script for defect, script in found.defects if script}
