"""Contacts with friction: what ESyS-Particle can be told of them, and ESyS-Particle itself."""

import re
import subprocess
from pathlib import Path

import pytest

import harness
from harness.cases.contact.verification import verify_trials
from harness.cases.registry import get_case
from harness.cases.verification import Study
from harness.comparison.known_defects import mark_known_defects
from harness.comparison.verdicts import Verdict
from harness.engines.esys.engine import RANKS, environment, find_launcher
from harness.store.baseline import known_defects

OBLIQUE = get_case("oblique")
PAIR = OBLIQUE.default.replace(partner="sphere")

DEFECTS = sorted((Path(harness.__file__).parent.parent / "reports" / "defects").glob("*/in.py"))


def found_in(engine, name, submodel, system):
    """Return what a case finds of a submodel in a system."""
    case = get_case(name)
    submodels = [one for one in (*case.submodels, *case.other_submodels) if one.name == submodel]
    trials = [one for one in case.trials("default", submodels) if one.system == system]
    return verify_trials(case, engine, Study("default"), trials)


@pytest.mark.live
@pytest.mark.slow
@pytest.mark.parametrize(
    ("submodel", "defect"), [("hooke", "rot-elastic-scaled"), ("hertz", "hertzian-elastic-half")]
)
def test_defects_of_elastic_contacts_are_found_by_name(esys, submodel, defect):
    found = found_in(esys, "head-on", submodel, "two spheres")
    told = mark_known_defects(
        found.checks, known_defects(), {"esys": esys.identify().engine_version}
    )
    known = [check for check in told if check.verdict is Verdict.KNOWN_DEFECT]
    assert {check.note.partition(":")[0] for check in known} == {f"known defect {defect}"}
    assert Verdict.FAIL not in {check.verdict for check in told}


@pytest.mark.live
@pytest.mark.parametrize("script", DEFECTS, ids=lambda path: path.parent.name)
def test_the_script_of_a_defect_finds_what_its_head_says(script, tmp_path, esys):
    version = esys.identify().engine_version
    if version not in esys.traits.versions:
        pytest.skip(f"ESyS-Particle {version} may not have it")
    done = subprocess.run(
        [*find_launcher(None), *RANKS, esys.program, str(script)], env=environment(tmp_path),
        cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip
    told = next(line for line in done.stdout.splitlines() if ": expected" in line)
    expected, found = (float(n) for n in re.findall(r"(?:expected|found) ([\d.]+)", told))
    text = script.read_text(encoding="utf-8")
    head = [float(n) for n in re.findall(r"(?:Expected|Found) ([\d.]+) N", text)]
    assert [expected, found] == pytest.approx(head, abs=1e-6)
    assert found < 0.9 * expected
