"""A program that passes for Yade: it answers each run of a batch with a recorded output.

Run as ``python fake_yade.py MODE RECORDED OPTIONS...``. At the angle 13 it does what MODE says
instead.
"""

import json
import math
import mmap
import os
import re
import signal
import sys
import time
from pathlib import Path


def misbehave(mode, results, text):
    if mode == "segfault":
        os.kill(os.getpid(), signal.SIGSEGV)
    elif mode == "hang":
        time.sleep(60)
    elif mode == "exceed memory":
        try:
            mmap.mmap(-1, 2 * 1024**3)
        except OSError:
            raise MemoryError from None
    elif mode == "nan":
        results.write_text(re.sub(r"(stage = 4600 \S+) \S+", r"\1 nan", text), encoding="utf-8")
    elif mode == "half a result":
        results.write_text(text[: len(text) // 2], encoding="utf-8")
        sys.exit(0)
    elif mode == "without a line":
        lines = [line for line in text.splitlines(keepends=True) if "stage = 4600" not in line]
        results.write_text("".join(lines), encoding="utf-8")
    elif mode == "exception":
        raise RuntimeError("Both materials should have the same defined set of variables")


def main(mode, recorded, options):
    if "--version" in options:
        print("Yade version: 2019.01a " if mode == "old" else "Yade version: 2023.02a ")
        return
    assert options[:3] == ["-n", "-x", "incline.py"]
    assert os.environ["HOME"] == str(Path.cwd())
    assert not any(name.startswith(("PYTHON", "OMPI_")) for name in os.environ)
    text = Path(recorded, "incline.txt").read_text(encoding="utf-8")
    path = Path(recorded, "incline.csv").read_text(encoding="utf-8")
    for run in json.loads(Path(options[3]).read_text(encoding="utf-8")):
        results = Path(run["results"])
        steep = run["gravity_x"] > 9.81 * math.sin(math.radians(12.0))
        if steep:
            misbehave(mode, results, text)
        if run["series"]:
            rows = path[:-30] if steep else path
            Path(run["series"]).write_text(rows, encoding="utf-8")
        if not results.exists():
            results.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], sys.argv[3:])
