"""What the READMEs show is what the project has."""

import ast
import re
import shlex
import textwrap
from pathlib import Path

import pytest

from harness.cli import COMMANDS, make_app

ROOT = Path(__file__).parents[1]
ROOMS = ("harness", "tests", "inputs", "reports")
PAGES = sorted(
    [
        ROOT / "CONTRIBUTING.md",
        ROOT / "README.md",
        *(path for room in ROOMS for path in (ROOT / room).rglob("README.md")),
    ]
)


def name(page):
    return str(page.relative_to(ROOT))


def blocks(page, language):
    """Return the blocks of code of a language in a page."""
    found = re.findall(rf"^ *```{language}\n(.*?)^ *```", page.read_text("utf-8"), re.M | re.S)
    return [textwrap.dedent(text) for text in found]


def shown(language):
    return [
        pytest.param(text, id=f"{name(page)}-{number}")
        for page in PAGES
        for number, text in enumerate(blocks(page, language))
    ]


def commands():
    """Return the lines of all pages that call dem-harness, and examples of the help, each once."""
    lines = [f"{name} {one}" for name, (_, _, *ones) in COMMANDS.items() for one in ones]
    for page in PAGES:
        for block in (b for b in blocks(page, "bash") if not b.startswith("#!")):
            whole = block.replace("\\\n", " ")
            lines += re.findall(r"(?:^|&& )(?:\S*/)?dem-harness ([^#&\n]+)", whole, re.MULTILINE)
    return sorted({line.strip() for line in lines})


def anchors(page):
    """Return the anchors of a page's headings, as GitHub makes them."""
    without_code = re.sub(r"```.*?```", "", page.read_text("utf-8"), flags=re.DOTALL)
    headings = re.findall(r"^#+ (.+)$", without_code, re.MULTILINE)
    return {re.sub(r"[^\w -]", "", text.lower()).replace(" ", "-") for text in headings}


def links():
    return [
        (page, link)
        for page in PAGES
        for link in sorted(set(re.findall(r"\]\(((?!http)[^)\s]+)\)", page.read_text("utf-8"))))
    ]


@pytest.mark.parametrize("text", [p for p in shown("python") if "class Small" not in p.values[0]])
def test_what_is_shown_in_python_runs(text, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    exec(compile(ast.parse(text), "<page>", "exec"), {"__name__": "shown"})


def broken(page, link):
    """Return whether a link leads to no file, or to no heading of it."""
    file, _, anchor = link.partition("#")
    target = page.parent / file if file else page
    return not target.exists() or (anchor and anchor not in anchors(target))


def test_every_link_leads_to_a_file_and_a_heading():
    assert [f"{name(page)}:{link}" for page, link in links() if broken(page, link)] == []


def test_every_command_is_understood():
    assert commands()
    refused = {}
    for line in commands():
        words = shlex.split(line)
        try:
            make_app(words).parse_args(words, exit_on_error=False, print_error=False)
        except Exception as error:
            refused[line] = str(error)
    assert refused == {}
