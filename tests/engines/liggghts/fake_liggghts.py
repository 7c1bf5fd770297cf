"""A program that passes for LIGGGHTS: it answers each job of a batch with a recorded log.

Run as ``python fake_liggghts.py MODE RECORDED OPTIONS...``. At the angle 13 it does what MODE
says instead.
"""

import os
import re
import signal
import sys
import time
from pathlib import Path

GREETING = "LIGGGHTS (Version LIGGGHTS-PUBLIC 3.8.0, compiled 2022, git commit unknown)\n"


def misbehave(mode, number, recorded):
    text = (recorded / "passage-moves-on.log").read_text(encoding="utf-8")
    text = re.sub(r"(RESULT angle_deg = ).*", r"\g<1>13", text)
    log, series = Path(f"{number}.log"), Path(f"{number}.csv")
    if mode == "segfault":
        os.kill(os.getpid(), signal.SIGSEGV)
    elif mode == "hang":
        time.sleep(60)
    elif mode == "silent":
        sys.exit(1)
    elif mode == "nothing":
        sys.exit(0)
    elif mode == "refuse":
        log.write_text((recorded / "refused-restitution.log").read_text(encoding="utf-8"))
        sys.exit(1)
    elif mode == "lose":
        log.write_text((recorded / "lost-atom.log").read_text(encoding="utf-8"))
        sys.exit(1)
    elif mode == "bad_alloc":
        print("terminate called after throwing an instance of 'std::bad_alloc'", flush=True)
        os.abort()
    elif mode == "nan":
        log.write_text(re.sub(r"(RESULT margin_J = ).*", r"\1-nan", text), encoding="utf-8")
    elif mode == "half a log":
        log.write_text(text[: len(text) // 2], encoding="utf-8")
        sys.exit(0)
    elif mode == "half a series":
        log.write_text(text, encoding="utf-8")
        rows = series.read_text(encoding="utf-8")
        series.write_text(rows[: rows.rindex(",")], encoding="utf-8")
    elif mode == "half a row":
        log.write_text(text, encoding="utf-8")
        rows = series.read_text(encoding="utf-8")
        series.write_text(rows[: rows.rindex(",")] + "\n", encoding="utf-8")


def main(mode, recorded, options):
    if "-help" in options:
        models = "hertz" if mode == "without model" else "hertz  hooke/stiffness"
        print(f"{GREETING}\n* Normal models for pair gran:\n\n{models}\n")
        return
    batch = Path("batch.in").read_text(encoding="utf-8")
    for number, job in enumerate(re.split(r"^log ", batch, flags=re.MULTILINE)[1:]):
        for kind, name in (("log", "passage-moves-on.log"), ("csv", "grain.csv")):
            text = (recorded / name).read_text(encoding="utf-8")
            angle = float(re.search(r"angle index (\S+)", job)[1])
            text = re.sub(r"(RESULT angle_deg = ).*", rf"\g<1>{angle}", text)
            Path(f"{number}.{kind}").write_text(text, encoding="utf-8")
        if float(re.search(r"angle index (\S+)", job)[1]) == 13.0:
            Path(f"{number}.log").unlink()
            misbehave(mode, number, recorded)


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]), sys.argv[3:])
