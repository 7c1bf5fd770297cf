"""The house: the arrow between its folders, what they name, and how large its parts may be."""

import ast
import re
from functools import cache
from pathlib import Path

import pytest

import harness
from harness.cases.registry import built_in
from harness.engines.registry import ENGINES

ROOT = Path(harness.__file__).parent
MODULES = sorted(ROOT.rglob("*.py"))
ANYWHERE = {"harness", "harness.errors", "harness.parameters", "harness.shown"}
FILES = {"harness.files"}
PROCESSES = {"harness.files"}
MEASURED = {*ANYWHERE, "harness.observables"}
JUDGED = {*MEASURED, "harness.comparison"}
PRODUCERS = {f"harness.{name}" for name in ("theory", "chain", "pair", "hard_sphere", "engines")}

ALLOWED = {
    "errors.py": set(),
    "shared_memory.py": set(),
    "parent_process.py": set(),
    "home.py": {"harness.errors"},
    "compiled.py": {"harness.files"},
    "atomic_write.py": {"harness.files"},
    "__init__.py": set(),
    "shown": set(),
    "parameters": {"harness.errors"},
    "theory": MEASURED,
    "chain": {*MEASURED, "harness.compiled"},
    "pair": {*ANYWHERE, "harness.compiled"},
    "hard_sphere": {"harness.errors", "harness.compiled"},
    "engines": {*MEASURED, *FILES, *PROCESSES, "harness.compiled"},
    "observables": ANYWHERE,
    "comparison": MEASURED,
    "report": {*JUDGED, "harness.files"},
    "store": {*JUDGED, *FILES, "harness.engines"},
    "cases": {*JUDGED, *PRODUCERS, "harness.report"},
    "workflows": {
        *JUDGED,
        *FILES,
        *(f"harness.{name}" for name in ("engines", "cases", "report", "store")),
    },
    "reproduction": {
        *JUDGED,
        *PRODUCERS,
        *(f"harness.{name}" for name in ("cases", "workflows", "report", "store", "atomic_write")),
    },
}
"""What the modules of a folder may import of the house. The command line and the plugin of pytest
stand above all and are not listed."""

TOP = {"cli", "__main__.py", "pytest_plugin.py"}

LAZY_API = "workflows/__init__.py"
"""The table of the functions that others call: it names where they are, whatever that is."""

OF_REPORT = ("harness.report.sections", "harness.report.style")
"""What cases may use of the report."""

WITHOUT_FILES = ("theory", "chain", "pair", "hard_sphere", "observables", "comparison")
PROCESSES_AND_FILES = {"subprocess", "pathlib", "tempfile", "shutil", "io", "multiprocessing"}

GENERIC = ("comparison", "store", "report", "workflows")
"""Folders that name no case and no engine."""

ENGLISH = {
    "reference", "drop", "oblique", "head-on", "spin", "twist", "bounce", "stacked", "pull-off",
    "columns",
}  # fmt: skip
"""Names that are words as well: only their imports can be told from the word."""

LINES, FUNCTION_LINES, PARAMETERS = 700, 60, 8


def folder(path):
    return path.relative_to(ROOT).parts[0]


def in_folders(names):
    return [path for path in MODULES if folder(path) in names]


def name(path):
    return path.relative_to(ROOT).as_posix()


@cache
def tree_of(path):
    return ast.parse(path.read_text(encoding="utf-8"))


@cache
def imports(path):
    """Return every module that a file imports, wherever in it, absolute names only."""
    return {module for node in ast.walk(tree_of(path)) for module in imported(node, path)}


def imported(node, path):
    if isinstance(node, ast.Import):
        return {alias.name for alias in node.names}
    if isinstance(node, ast.ImportFrom):
        assert node.level == 0, f"{path}: relative import"
        # from harness import chain: the name may be a module of its own
        return {f"{node.module}.{alias.name}" for alias in node.names}
    return set()


def part_of_house(module):
    """Return harness.<folder> for a module of the harness, harness for its own names."""
    parts = module.split(".")
    inside = len(parts) > 1 and ((ROOT / parts[1]).is_dir() or (ROOT / f"{parts[1]}.py").is_file())
    return ".".join(parts[:2]) if inside else "harness"


def of_house(path):
    return {module for module in imports(path) if module.split(".")[0] == "harness"}


@pytest.mark.parametrize("path", in_folders(ALLOWED), ids=name)
def test_arrows_between_the_folders(path):
    house = {part_of_house(module) for module in of_house(path)}
    own = "harness." + folder(path).removesuffix(".py")
    beyond = house - {own} - ALLOWED[folder(path)]
    assert not beyond or name(path) == LAZY_API


def test_every_folder_of_the_house_is_covered():
    parts = {folder(path) for path in MODULES}
    assert parts == {*ALLOWED, *TOP}


@pytest.mark.parametrize("path", MODULES, ids=name)
def test_nothing_imports_what_stands_above_it(path):
    house = {part_of_house(module) for module in of_house(path)}
    if folder(path) not in ("cli", "reproduction"):
        assert "harness.reproduction" not in house
    if folder(path) not in ("cli", "__main__.py"):
        assert "harness.cli" not in house


@pytest.mark.parametrize("path", in_folders(["cases"]), ids=name)
def test_a_case_uses_no_other_case_and_only_sections_of_the_report(path):
    own = ".".join(("harness", *path.relative_to(ROOT).with_suffix("").parts[:2]))
    packages = {f"harness.cases.{case}" for case in cases()}
    used = {".".join(module.split(".")[:3]) for module in of_house(path)}
    assert not (used & packages) - {own} - GREW_OUT_OF.get(own, set())
    of_report = {module for module in of_house(path) if part_of_house(module) == "harness.report"}
    assert all(module.startswith(OF_REPORT) for module in of_report)


def cases():
    """Return the folders of cases; one without a module ``case`` is what several cases share."""
    return [child.name for child in (ROOT / "cases").iterdir() if (child / "case.py").is_file()]


def engine_folders():
    return [child.name for child in (ROOT / "engines").iterdir() if (child / "engine.py").is_file()]


GREW_OUT_OF = {"harness.cases.columns": {"harness.cases.incline"}}
"""A case that is another one in a limit: it reads and judges as that does."""

SCRIPT_LANGUAGE = {"harness.engines.liggghts": {"harness.engines.lammps"}}
"""A code that grew out of another writes its scripts in the other's language."""


@pytest.mark.parametrize("path", in_folders(["engines"]), ids=name)
def test_an_engine_uses_no_other_engine(path):
    parts = path.relative_to(ROOT).with_suffix("").parts
    own = ".".join(("harness", *parts[:2]))
    packages = {f"harness.engines.{engine}" for engine in engine_folders()}
    used = {".".join(module.split(".")[:3]) for module in of_house(path)}
    assert not (used & packages) - {own} - SCRIPT_LANGUAGE.get(own, set())


def names_in(text, names):
    return {word for word in names if re.search(rf"(?<![a-z]){word}(?![a-z])", text.lower())}


def unambiguous(names):
    return {word for word in names if word not in ENGLISH}


@pytest.mark.parametrize("path", in_folders(GENERIC), ids=name)
def test_generic_folders_name_no_case_and_no_engine(path):
    if name(path) == LAZY_API:
        return
    text = path.read_text(encoding="utf-8").replace("dem_harness", "")
    assert not names_in(text, unambiguous({*built_in(), *ENGINES}))
    packages = [f"harness.cases.{case}" for case in cases()]
    packages += [f"harness.engines.{engine}" for engine in engine_folders()]
    assert not [module for module in of_house(path) if module.startswith(tuple(packages))]


@pytest.mark.parametrize("path", in_folders(["engines"]), ids=name)
def test_engines_name_no_case(path):
    assert not names_in(path.read_text(encoding="utf-8"), unambiguous(built_in()))


@pytest.mark.parametrize("path", sorted((ROOT / "engines").glob("*.py")), ids=name)
def test_what_engines_share_names_none_of_them(path):
    if path.name == "registry.py":
        return
    assert not names_in(path.read_text(encoding="utf-8"), unambiguous(ENGINES))


@pytest.mark.parametrize("path", in_folders(WITHOUT_FILES), ids=name)
def test_physics_opens_no_file_and_starts_no_process(path):
    assert not {m.split(".")[0] for m in imports(path)} & PROCESSES_AND_FILES
    calls = [node.func for node in ast.walk(tree_of(path)) if isinstance(node, ast.Call)]
    called = {c.id for c in calls if isinstance(c, ast.Name)}
    called |= {c.attr for c in calls if isinstance(c, ast.Attribute)}
    assert not called & {"open", "system", "popen", "read_text", "write_text", "to_csv", "savetxt"}


@pytest.mark.parametrize("path", MODULES, ids=name)
def test_no_module_is_long_and_no_function_long_or_wide(path):
    assert len(path.read_text(encoding="utf-8").splitlines()) <= LINES
    for node in ast.walk(tree_of(path)):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            assert node.end_lineno - node.lineno + 1 <= FUNCTION_LINES, node.name
            given = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
            taken = [one for one in given if one.arg not in ("self", "cls")]
            decorators = [ast.unparse(one) for one in node.decorator_list]
            compiled = any(one.startswith(("compiled", "njit")) for one in decorators)
            # a compiled kernel takes arrays and numbers, no objects
            assert compiled or len(taken) <= PARAMETERS, node.name


def module_name(path):
    parts = path.relative_to(ROOT.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imported_at_once(path, known):
    """Return the modules of the house that are imported with a module, before any call."""
    found = set()
    pending = list(tree_of(path).body)
    while pending:
        node = pending.pop()
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            continue
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            pending += node.orelse
            continue
        found |= imported(node, path)
        pending += ast.iter_child_nodes(node)
    modules = {m if m in known else m.rpartition(".")[0] for m in found}
    return {module for module in modules if module in known}


def test_there_is_no_circle_of_imports():
    known = {module_name(path): path for path in MODULES}
    beyond = {module: imported_at_once(path, known) for module, path in known.items()}
    done, open_now = set(), []

    def visit(module):
        assert module not in open_now, " -> ".join([*open_now[open_now.index(module) :], module])
        if module in done:
            return
        open_now.append(module)
        for other in sorted(beyond[module] - {module}):
            visit(other)
        open_now.pop()
        done.add(module)

    for module in sorted(known):
        visit(module)


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("from harness import chain", {"harness.solvers.chain"}),
        ("def f():\n    import harness.report.page", {"harness.report.page"}),
        ("from harness.theory.shock import x", {"harness.theory.chain.x"}),
    ],
)
def test_imports_are_seen_in_every_form(tmp_path, text, found):
    path = tmp_path / "module.py"
    path.write_text(text, encoding="utf-8")
    assert imports(path) == found


def test_names_are_seen_in_code_and_text():
    assert names_in('run_lammps("x")', {"lammps"}) == {"lammps"}
    assert names_in("# as LAMMPS does", {"lammps"}) == {"lammps"}
    assert names_in("inclined, towers", {"incline", "tower"}) == set()
