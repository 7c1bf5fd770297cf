"""What LAMMPS and LIGGGHTS once wrote, as version, packages and errors."""

from pathlib import Path

import pytest

from harness.engines.lammps_language import (
    check_log,
    error_from_text,
    error_of,
    packages_in,
    version_in,
)
from harness.engines.process import Ended
from harness.errors import (
    EngineCrashError,
    EngineInputError,
    EngineLostAtomsError,
    EngineMemoryError,
    EngineMissingError,
    EngineOutputError,
    EngineUnsupportedError,
)

LIGGGHTS = Path(__file__).parents[1] / "liggghts" / "recorded"


@pytest.mark.parametrize(
    ("year", "version"),
    [
        (2022, "23 Jun 2022 - Update 4"),
        (2025, "22 Jul 2025 - Update 4"),
    ],
)
def test_release_and_packages_of_a_help_text(recorded, year, version):
    text = recorded(f"help-{year}.txt")
    assert version_in(text) == version
    assert {"GRANULAR", "ASPHERE", "CG-DNA"} <= {*packages_in(text)}


def test_a_text_of_another_program_names_no_release():
    with pytest.raises(EngineMissingError, match="this is not LAMMPS"):
        version_in("GNU coreutils 9.1")


@pytest.mark.parametrize(
    ("name", "kind", "words"),
    [
        ("lost-atom", EngineLostAtomsError, "Lost atoms"),
        ("memory", EngineMemoryError, "Failed to reallocate 4000055296 bytes"),
        ("unknown-damping", EngineInputError, "comparing string to number"),
        ("no-coeff-restitution-2022", EngineInputError, "Illegal pair_coeff command"),
        ("no-coeff-restitution-2023", EngineInputError, "coeff_restitution"),
    ],
)
def test_the_last_line_of_a_log_is_the_reason(recorded, name, kind, words):
    text = recorded(f"{name}.log")
    error = error_from_text(text, 1)
    assert type(error) is kind
    assert words in str(error)
    assert "\n" not in str(error)
    with pytest.raises(EngineOutputError if "lost" not in name else EngineLostAtomsError):
        check_log(text)


@pytest.mark.parametrize(
    ("name", "kind"),
    [("lost-atom", EngineLostAtomsError), ("refused-restitution", EngineInputError)],
)
def test_errors_of_liggghts_are_in_the_same_words(name, kind):
    error = error_from_text((LIGGGHTS / f"{name}.log").read_text("utf-8"), 1, "LIGGGHTS")
    assert type(error) is kind
    assert str(error).startswith("LIGGGHTS ")


@pytest.mark.parametrize(
    ("said", "file"),
    [
        ("Fix wall/gran/kk doesn't yet support hertz/history style", "fix_wall_gran"),
        ("Fix neigh/history/kk requires newton 'off' for exchange communication", "neigh_history"),
    ],
)
def test_what_kokkos_lacks_is_not_supported_in_the_words_of_lammps(said, file):
    log = f"run 100\nERROR: {said} (src/KOKKOS/{file}_kokkos.cpp:128)\n"
    error = error_of(Ended("", 1, 0.1, timed_out=False), log)
    assert isinstance(error, EngineUnsupportedError)
    assert said in str(error)


def test_a_signal_is_the_reason_whatever_the_log_ends_with(recorded):
    assert isinstance(error_from_text(recorded("lost-atom.log"), -11), EngineCrashError)
