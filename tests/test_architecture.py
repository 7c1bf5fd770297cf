import ast
from pathlib import Path

import pytest

import harness

ROOT = Path(harness.__file__).parent
MODULES = sorted(ROOT.rglob("*.py"))
ANYWHERE = {"harness", "harness.errors", "harness.parameters"}

ALLOWED = {
    "errors.py": set(),
    "atomic_write.py": set(),
    "parameters": {"harness.errors"},
    "theory": {*ANYWHERE, "harness.observables"},
    "chain": {*ANYWHERE, "harness.observables"},
    "engines": {*ANYWHERE, "harness.observables"},
    "observables": ANYWHERE,
    "comparison": {*ANYWHERE, "harness.observables"},
    "store": {
        *ANYWHERE,
        "harness.atomic_write",
        "harness.observables",
        "harness.comparison",
        "harness.engines",
    },
    "report": {
        *ANYWHERE,
        "harness.atomic_write",
        "harness.observables",
        "harness.comparison",
    },
}
WITHOUT_FILES = ("theory", "chain", "observables", "comparison")
PROCESSES_AND_FILES = {"subprocess", "pathlib", "tempfile", "shutil", "io", "multiprocessing"}


def folder(path):
    return path.relative_to(ROOT).parts[0]


def in_folders(names):
    return [path for path in MODULES if folder(path) in names]


def name(path):
    return str(path.relative_to(ROOT))


def imports(path):
    """Return every module that a file imports, wherever in it, absolute names only."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            # from harness import chain: the name may be a module of its own
            found |= {f"{node.module}.{alias.name}" for alias in node.names}
    return found


def part_of_house(module):
    """Return harness.<folder> for a module of the harness, harness for its own names."""
    parts = module.split(".")
    inside = len(parts) > 1 and ((ROOT / parts[1]).is_dir() or (ROOT / f"{parts[1]}.py").is_file())
    return ".".join(parts[:2]) if inside else "harness"


@pytest.mark.parametrize("path", in_folders(ALLOWED), ids=name)
def test_arrows_between_the_folders(path):
    house = {part_of_house(m) for m in imports(path) if m.split(".")[0] == "harness"}
    own = "harness." + folder(path).removesuffix(".py")
    assert house - {own} <= ALLOWED[folder(path)]


@pytest.mark.parametrize("path", MODULES, ids=name)
def test_only_the_command_line_imports_the_report_and_nothing_imports_the_command_line(path):
    house = {part_of_house(m) for m in imports(path) if m.startswith("harness.")}
    if folder(path) not in ("cli", "report", "reproduction"):
        assert "harness.report" not in house
    if folder(path) not in ("cli", "reproduction"):
        assert "harness.reproduction" not in house
    if folder(path) not in ("cli", "__main__.py"):
        assert "harness.cli" not in house


@pytest.mark.parametrize("path", in_folders(WITHOUT_FILES), ids=name)
def test_physics_opens_no_file_and_starts_no_process(path):
    assert not {m.split(".")[0] for m in imports(path)} & PROCESSES_AND_FILES
    tree = ast.parse(path.read_text(encoding="utf-8"))
    calls = [node.func for node in ast.walk(tree) if isinstance(node, ast.Call)]
    called = {c.id for c in calls if isinstance(c, ast.Name)}
    called |= {c.attr for c in calls if isinstance(c, ast.Attribute)}
    assert not called & {"open", "system", "popen", "read_text", "write_text", "to_csv", "savetxt"}


def test_every_folder_of_the_house_is_covered():
    folders = {path.name for path in ROOT.iterdir() if path.is_dir() and any(path.glob("*.py"))}
    assert folders - {"cli", "workflows", "cases", "reproduction"} == {
        key for key in ALLOWED if not key.endswith(".py")
    }


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("from harness import chain", {"harness.chain"}),
        ("def f():\n    import harness.report.page", {"harness.report.page"}),
        ("from harness.theory.shock import x", {"harness.theory.shock.x"}),
    ],
)
def test_imports_are_seen_in_every_form(tmp_path, text, found):
    path = tmp_path / "module.py"
    path.write_text(text, encoding="utf-8")
    assert imports(path) == found
