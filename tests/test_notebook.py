"""The example notebook, executed: it runs, and gives what is committed."""

from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
NOTEBOOK = ROOT / "reports" / "example" / "notebook.ipynb"
QUIET = "ignore::DeprecationWarning", "ignore::RuntimeWarning"  # of Jupyter's own libraries


def outputs(notebook):
    """Return what each cell gave: what was printed, or its data by kind."""
    given = [output for cell in notebook.cells for output in cell.get("outputs", ())]
    return [output.get("data", {"text": output.get("text")}) for output in given]


@pytest.mark.slow
@pytest.mark.live
@pytest.mark.filterwarnings(*QUIET)
def test_the_notebook_runs_and_gives_what_it_shows(lammps_here, monkeypatch):  # noqa: ARG001
    nbformat = pytest.importorskip("nbformat")
    client = pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    committed = nbformat.read(NOTEBOOK, as_version=4)
    shown = outputs(committed)
    again = nbformat.from_dict(committed)
    client.NotebookClient(
        again, timeout=240, kernel_name="python3", resources={"metadata": {"path": str(ROOT)}}
    ).execute()
    fresh = outputs(again)
    assert [sorted(one) for one in fresh] == [sorted(one) for one in shown]
    # the angle to the first digit of its uncertainty is the same wherever LAMMPS runs
    assert fresh[1]["text/plain"].splitlines()[:3] == shown[1]["text/plain"].splitlines()[:3]
    assert "All verdicts hold" in fresh[-2]["text/plain"]
