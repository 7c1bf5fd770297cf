"""Find the git commit of the harness, where it runs from a checkout."""

from __future__ import annotations

import subprocess

from harness.store.keys import ROOT


def commit() -> str:
    """Return the commit, with ``-dirty`` where files were edited; empty outside a checkout."""
    folder = ROOT.parent
    if not (folder / ".git").exists():
        return ""
    command = ["git", "-C", str(folder), "describe", "--always", "--dirty", "--exclude", "*"]
    try:
        done = subprocess.run(
            [*command, "--abbrev=40"],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=10.0,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return done.stdout.strip() if done.returncode == 0 else ""
