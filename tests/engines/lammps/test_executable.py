"""What is LAMMPS's own in running its executable; faults of runs are in ``test_faults``."""

import os
import re
import shutil
from pathlib import Path

import pytest

from harness.cases.drop import CASE
from harness.cases.registry import get_case
from harness.engines.base import scene_job
from harness.engines.lammps.engine import Lammps
from harness.engines.registry import program_words
from harness.errors import EngineMissingError
from tests.engines.lammps.scenes import BOWL, LAWS, LOW, SCENES, SYSTEMS, on_wall

LOADER = "lmp: error while loading shared libraries: libmpi.so.12: cannot open shared object file"
HELP = (
    "Large-scale Atomic/Molecular Massively Parallel Simulator - 22 Jul 2025\n"
    "Installed packages:\n\nKSPACE MC"
)


@pytest.mark.parametrize(
    ("said", "words"),
    [
        (HELP, r"fake-lmp .* without the GRANULAR package"),
        (LOADER, r"not run.*libmpi\.so\.12: "),
    ],
)
def test_an_executable_that_cannot_be_used_is_named_with_the_reason(script_file, said, words):
    with (
        Lammps(lmp=script_file(f"cat <<'END'\n\n{said}\nEND\nexit 127\n")) as engine,
        pytest.raises(EngineMissingError, match=words),
    ):
        engine.identify()


def test_words_after_the_program_are_its_arguments_and_a_file_is_taken_whole(script_file):
    plain, blank = script_file("", "lmp"), script_file("", "lmp -sf omp")
    assert program_words("lmp", blank) == [blank]
    assert program_words("lmp", f"{plain} -sf  opt") == [plain, "-sf", "opt"]
    assert program_words("lmp", f"'{blank}' -pk omp 2") == [blank, "-pk", "omp", "2"]


@pytest.mark.live
def test_arguments_reach_every_run_and_stand_where_it_came_from(lmp_binary):
    job = CASE.job(CASE.default.replace(steps_per_contact=100.0))
    program = f"{lmp_binary} -sf omp"
    with Lammps(lmp=program, workers=1) as engine, Lammps(lmp=lmp_binary, workers=1) as plain:
        outputs = [one.run([job])[0] for one in (engine, plain)]
        assert engine.identify().how == "executable, -sf omp"
        assert engine.identify().executable == lmp_binary
    there, here = (output.tables["series"]["vy_m_per_s"] for output in outputs)
    assert there == pytest.approx(here, rel=1e-9)
    assert outputs[0].log.startswith("# lmp -sf omp -in drop.in")


def test_with_kokkos_contacts_run_whose_styles_have_a_variant(script_file):
    """Also a script with walls that exert no force there is refused."""
    said = f"{HELP.replace('KSPACE', 'GRANULAR')}\n\ngran/hooke/history/kk wall/gran/kk"
    program = script_file(f"[ $1 = -h ] && cat <<END || echo 'LAMMPS (1)'\n{said}\nEND\n")
    history = LAWS["gran/hooke/history"]
    refused = {
        "wall/gran/region has no variant kk in this LAMMPS": on_wall(BOWL, LOW, history),
        "gran/hooke has no variant kk in this LAMMPS: it": SYSTEMS["wall"](LAWS["gran/hooke"]),
        "granular has no variant kk": SYSTEMS["spheres"](LAWS["linear_history"]),
    }
    silo, old = get_case("silo"), scene_job(SYSTEMS["wall"](history))
    with Lammps(lmp=f"{program} -k on -sf kk") as engine, Lammps(lmp=program) as plain:
        for reason, scene in refused.items():
            assert engine.refuses(scene_job(scene)).startswith(reason)
            assert not plain.refuses(scene_job(scene))
        assert engine.refuses(silo.job(silo.default)).startswith("fix wall/gran/kk has no style")
        assert not engine.refuses(CASE.job(CASE.default))
        assert not engine.refuses(old)
        how = engine.identify().how  # of the scripts that run
        assert how == "executable, pair_style granular without kk, -k on -sf kk"
        assert " bin\n" in engine.scene_script(old)  # KOKKOS refuses nsq
        assert " nsq\n" in plain.scene_script(old)


@pytest.mark.live
def test_arguments_that_lammps_does_not_take_are_refused_in_its_words(lmp_binary):
    said = "-nonsense x' does not start: ERROR: Invalid command-line argument: -nonsense"
    program = f"{lmp_binary} -nonsense x"
    with Lammps(lmp=program) as engine, pytest.raises(EngineMissingError, match=said):
        engine.identify()


def test_a_launcher_of_another_mpi_is_refused(script_file):
    said = HELP.replace("KSPACE", "GRANULAR")
    greeting = "LAMMPS (22 Jul 2025)"
    lmp = script_file(f"[ $1 = -h ] && cat <<END || echo '{greeting}'\n{said}\nEND\n", "lmp")
    mpirun = script_file('shift\n"$@"\n"$@"\n', "mpirun")
    with (
        Lammps(lmp=lmp, launcher=f"{mpirun} -2") as engine,
        pytest.raises(
            EngineMissingError, match=r"^--mpirun .* starts 2 separate LAMMPS instead of"
        ),
    ):
        engine.identify()


@pytest.mark.live
def test_ranks_are_not_tested_by_a_launcher_of_another_mpi(lmp_binary, script_file, monkeypatch):
    """Two LAMMPS of one rank would write over each other's files."""
    launcher = script_file('shift 2\n"$@"\n"$@"\n', "mpirun")
    monkeypatch.setenv("PATH", str(Path(launcher).parent), prepend=os.pathsep)
    program = Path(launcher).parent / "alone" / "lmp"  # with no mpirun beside it
    program.parent.mkdir()
    shutil.copy(lmp_binary, program)
    scene = SCENES["rolling, prescribed"]
    with Lammps(lmp=str(program), workers=1) as engine:
        jobs = [scene_job(scene), scene_job(scene, variation="two ranks, newton on")]
        alone, ranks = engine.motions(jobs)
    assert alone.time.size > 1
    assert isinstance(ranks, EngineMissingError)
    assert re.match("mpirun on PATH: 'mpirun -n 2 .*' starts 2 separate LAMMPS", str(ranks))
