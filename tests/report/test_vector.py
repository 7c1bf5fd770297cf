import re
from urllib.parse import unquote
from xml.etree import ElementTree

import pytest

from harness.report.gallery import compact, data_uri, size
from harness.report.gallery import picture as draw_picture
from tests.report.conftest import draw

FIGURE = """<?xml version="1.0"?>
<svg width="72pt" height="36pt" viewBox="0 0 72 36" xmlns="http://www.w3.org/2000/svg">
 <metadata><a/></metadata> <!-- a "comment" -->
 <path d="M 1.23456789 -0.001
L 3.999999 4" transform="scale(0.015625)"/>
</svg>"""


def test_paths_keep_a_hundredth_of_a_point_and_the_rest_its_value():
    small = compact(FIGURE)
    assert "1.23 -0 L 4 4" in small.replace("\n", " ")
    assert "scale(0.015625)" in small
    assert "metadata" not in small
    assert size(small) == (72.0, 36.0)


@pytest.fixture(scope="module")
def picture():
    return draw_picture("sine", "Sine", "A sine.", draw())


def test_what_a_figure_refers_to_is_in_it_and_each_style_is_said_once(picture):
    root = ElementTree.fromstring(picture.svg)
    found = {node.get("id") for node in root.iter()} - {None}
    assert found == set(re.findall(r'(?:url\(|href=")#([^)"]+)', picture.svg))
    sheet = re.findall(r"\.(s\d+)\{([^}]+)\}", picture.svg)
    assert len({style for _, style in sheet}) == len(sheet) > 3
    assert {node.get("class") for node in root.iter()} - {None} == {name for name, _ in sheet}
    assert all(node.attrib for node in root.iter() if node.tag.endswith("}g"))


def test_the_uri_stands_in_an_attribute_and_gives_the_figure_back(picture):
    uri = data_uri(picture.svg)
    assert not set('"#&') & set(uri)
    assert unquote(uri.removeprefix("data:image/svg+xml,")) == picture.svg.replace("\n", " ")
