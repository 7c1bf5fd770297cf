import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.cases.incline.system import Incline
from harness.cases.incline.system import job_of as incline_job
from harness.cases.tower.system import job_of as tower_job
from harness.cases.tower.system import timing_of
from harness.parameters.law import CLIPPED, SOURCE, Contact
from harness.parameters.tower import Tower
from harness.store import entries
from harness.store.cache import SOURCES, run_key
from harness.store.entries import digest_of_tree, source_digest

ENGINE = {"engine": "lammps", "how": "in-process", "files": ["abc liblammps.so"]}


def key(case, route="passage", every=None, who=ENGINE):
    """Return the key of a run of an incline."""
    return run_key(Lammps, incline_job(case, route, every), who)


def tower_key(case, samples=100):
    """Return the key of a run of a tower."""
    return run_key(Lammps, tower_job(case, timing_of(case, 1.0, None, samples)), ENGINE)


class Lammps:
    """Stands in for an engine: its scripts are known by their names."""

    @staticmethod
    def script_digest(job):
        return job.variant or "main"


CHANGED_INCLINE = {
    "angle": 10.3,
    "stiffness": 1.0000001e6,
    "contact": CLIPPED,
    "steps_per_contact": 51.0,
    "diameter": 1.5,
    "density": 2.0,
    "gravity": 9.80,
    "spheres": 10,
    "wells": 11,
    "phase": 0.5,
    "time_limit": 401.0,
}
CHANGED_CONTACT = {
    "name": "another",
    "restitution": 2e-20,
    "damping_ratio": 1.0,
    "tail": "clipped",
    "effective_mass": "half",
}
CHANGED_TOWER = {
    "height": 4,
    "stiffness": 2e6,
    "mass": 2.0,
    "diameter": 2.0,
    "speed": 3.0,
    "gravity": 0.0,
    "law": "overlap",
    "base": "free",
    "start": "preloaded",
    "gap": 1e-3,
}


def test_the_tables_of_changes_name_every_parameter():
    assert CHANGED_INCLINE.keys() == Incline.model_fields.keys()
    assert CHANGED_CONTACT.keys() == Contact.model_fields.keys()
    assert CHANGED_TOWER.keys() == Tower.model_fields.keys()


@pytest.mark.parametrize(
    "changes",
    [
        *({name: value} for name, value in CHANGED_INCLINE.items()),
        *({"contact": SOURCE.replace(**{n: value})} for n, value in CHANGED_CONTACT.items()),
    ],
)
def test_every_parameter_of_the_incline_and_its_contact_changes_the_key(changes):
    assert key(Incline().replace(**changes)) != key(Incline())


@pytest.mark.parametrize("name", CHANGED_TOWER)
def test_every_parameter_of_the_tower_changes_the_key(name):
    base = Tower(height=3)
    more = {"start": "gapped"} if name == "gap" else {}
    reference = base.replace(start="gapped", gap=2e-3) if name == "gap" else base
    changed = base.replace(**{name: CHANGED_TOWER[name]}, **more)
    assert tower_key(changed) != tower_key(reference)


@pytest.mark.parametrize(
    "change",
    [
        {"engine": "another"},
        {"how": "mpirun -np 2"},
        {"files": ["abd liblammps.so"]},
        {"environment": {"LD_PRELOAD": "x.so"}},
    ],
)
def test_every_fact_of_the_engine_changes_the_key(change):
    assert key(Incline(), who=ENGINE | change) != key(Incline())


@pytest.mark.parametrize("change", [{"route": "steady"}, {"every": 100}])
def test_every_option_of_a_run_changes_the_key(change):
    assert key(Incline(), **change) != key(Incline())
    assert tower_key(Tower(), samples=50) != tower_key(Tower())


def test_a_scene_is_known_by_the_source_that_makes_it(monkeypatch):
    monkeypatch.setattr(Lammps, "script_digest", staticmethod(lambda _: ""))
    first = key(Incline())
    monkeypatch.setattr("harness.store.cache.source_digest", lambda *rooms: str(rooms))
    assert key(Incline()) != first
    seen = []
    monkeypatch.setattr("harness.store.cache.source_digest", lambda *r: seen.append(r))
    key(Incline())
    assert ("cases",) in seen


@pytest.mark.parametrize("fact", ["machine", "versions", "source_digest"])
def test_platform_packages_and_source_change_the_key(monkeypatch, fact):
    first = key(Incline())
    monkeypatch.setattr(f"harness.store.cache.{fact}", lambda *_: {"other": "1"})
    assert key(Incline()) != first


numbers = st.floats(1e4, 1e9) | st.integers(10_000, 1_000_000_000).map(float)


@given(numbers, numbers)
def test_stiffnesses_share_a_key_only_when_they_are_the_same_double(one, other):
    first, second = (key(Incline(stiffness=k)) for k in (one, other))
    assert (first == second) == (one == other)


def test_the_digest_of_a_folder_sees_contents_names_and_no_caches(tmp_path):
    (tmp_path / "a.py").write_text("1")
    first = digest_of_tree(tmp_path)
    (tmp_path / "__pycache__").mkdir()
    (tmp_path / "__pycache__" / "a.pyc").write_text("x")
    assert digest_of_tree(tmp_path) == first
    (tmp_path / "a.py").write_text("2")
    second = digest_of_tree(tmp_path)
    (tmp_path / "a.py").rename(tmp_path / "b.py")
    assert len({first, second, digest_of_tree(tmp_path)}) == 3


def test_an_edit_of_the_source_changes_its_digest(tmp_path, monkeypatch):
    for room in (*SOURCES, "report"):
        (tmp_path / room).mkdir()
        (tmp_path / room / "law.py").write_text("force = k * overlap")
    monkeypatch.setattr(entries, "ROOT", tmp_path)
    digests = []
    for text in ("force = k * overlap", "force = 2 * k * overlap"):
        (tmp_path / "engines" / "law.py").write_text(text)
        source_digest.cache_clear()
        digests.append((source_digest(), source_digest(*SOURCES), source_digest("report")))
    source_digest.cache_clear()
    whole, rooms, report = zip(*digests, strict=True)
    assert whole[0] != whole[1]
    assert rooms[0] != rooms[1]
    assert report[0] == report[1]
