"""Engines whose bulk scripts are changed, which codes are here, and outputs that are made up."""

import shutil
from dataclasses import replace
from importlib.util import find_spec

import pytest

from harness.engines.output import Output
from harness.observables.provenance import Provenance

HERE = {
    "lammps": find_spec("lammps") is not None,
    "liggghts": shutil.which("liggghts") is not None,
    "yade": shutil.which("yade") is not None,
    "kratos": find_spec("KratosMultiphysics") is not None,
}
LIGGGHTS = pytest.mark.skipif(not HERE["liggghts"], reason="liggghts is not installed")


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
