"""Templates of pages."""

from pathlib import Path

import pytest
from jinja2 import UndefinedError

from movingout.recordings.html_page import templates, write_html


def test_every_value_is_escaped_and_a_missing_one_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "one.html.j2").write_text(
        '{% extends "layout.html.j2" %}{% block main %}<b>{{ note }}</b>{% endblock %}'
    )
    template = templates(tmp_path).get_template("one.html.j2")
    page = template.render(title="a < b", note="<script>alert('x')</script>")
    assert "<title>a &lt; b</title>" in page
    assert "<b>&lt;script&gt;alert(&#39;x&#39;)&lt;/script&gt;</b>" in page
    with pytest.raises(UndefinedError):
        template.render(title="a < b")


def test_the_name_of_a_file_that_is_not_utf8_stops_no_page(tmp_path: Path) -> None:
    write_html("<b>caf\udce9.mcap</b>", tmp_path / "page.html")
    assert (tmp_path / "page.html").read_text(encoding="utf-8") == "<b>caf?.mcap</b>"
