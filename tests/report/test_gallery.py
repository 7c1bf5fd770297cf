"""Figures are drawn by forked processes, which end with the one that forked them."""

import os
import signal
import subprocess
import sys

DRAWS = """
import time
from harness.report.gallery import draw_sections
from harness.report.sections import Drawing, Section

def draw():
    print("draws", flush=True)
    time.sleep(300.0)

drawings = tuple(Drawing(f"figure-{i}", "Title", "Caption", draw) for i in range(4))
draw_sections([Section("Title", (), drawings=drawings)])
"""


def test_a_kill_leaves_no_process_that_draws():
    process = subprocess.Popen(
        [sys.executable, "-c", DRAWS], stdout=subprocess.PIPE, env={**os.environ}
    )
    assert process.stdout.readline().startswith(b"draws")  # both may at once
    process.send_signal(signal.SIGKILL)
    # the pipe ends when the last process that holds it does
    process.communicate(timeout=60)
    assert process.returncode == -signal.SIGKILL
