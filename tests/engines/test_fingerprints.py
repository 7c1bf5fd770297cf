"""What runs of other codes are kept under: a changed installation is another one."""

import os
import shutil
import sys
from pathlib import Path

import pytest

from harness.engines import registry
from harness.engines.kratos.engine import Kratos
from harness.engines.lammps.engine import Lammps
from harness.engines.mfix.engine import Mfix
from harness.engines.yade.engine import Yade

TRUE = Path(shutil.which("true")).resolve()
"""A program with libraries, small."""


def tree(folder, *names):
    for name in names:
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("content")


def yade(folder):
    tree(folder, "lib/yade/py/yade/__init__.py", "lib/yade/libpkg_dem.so")
    shutil.copy(TRUE, folder / "lib/yade/libyade.so")
    program = folder / "yade"
    lines = (
        f"#!{Path(sys.executable).resolve()}",
        f"sys.path.insert(1,'{folder}/lib/yade/py')",
        "",
    )
    program.write_text("\n".join(lines))
    program.chmod(0o755)
    return Yade, {"program": str(program)}, folder / "lib/yade/libpkg_dem.so"


def kratos(folder, monkeypatch):
    tree(folder, "KratosMultiphysics/__init__.py", "KratosMultiphysics/.libs/KratosCore.so")
    monkeypatch.setenv("PYTHONPATH", str(folder))
    return Kratos, {}, folder / "KratosMultiphysics/.libs/KratosCore.so"


def mfix(folder):
    program = Path(shutil.copy(TRUE, folder / "mfixsolver"))
    return Mfix, {"program": str(program)}, program


def lammps(folder):
    program = Path(shutil.copy(TRUE, folder / "lmp"))
    return Lammps, {"lmp": str(program)}, program


@pytest.mark.parametrize("name", ["yade", "kratos", "mfix", "lammps"])
def test_a_changed_file_of_an_installation_is_another_engine(tmp_path, monkeypatch, name):
    more = (monkeypatch,) if name == "kratos" else ()
    kind, options, file = globals()[name](tmp_path, *more)
    # read again as by another command
    monkeypatch.setattr(registry, "digest", registry.digest.__wrapped__)
    before = kind(**options).fingerprint()
    assert before is not None
    os.utime(file, (1, 1))
    assert before == kind(**options).fingerprint()
    assert name in ("yade", "kratos") or any("libc" in file for file in before["files"])
    with file.open("ab") as stream:
        stream.write(b"\0")
    assert kind(**options).fingerprint() != before


@pytest.mark.parametrize("kind", [Yade, Kratos, Mfix])
def test_of_a_wrapper_nothing_is_kept(script_file, kind):
    """It hides the program that it runs."""
    assert kind(script_file('exec true "$@"\n')).fingerprint() is None
