"""Pages: what goes into HTML is escaped, Markdown is left alone, a missing value is an error."""

import pytest
from jinja2 import UndefinedError

from drake_linefoot.lab.results.page import render

HTML = """\
{% extends "page.html.j2" %}
{% from "parts.html.j2" import table %}
{% block body %}
<p>{{ text }}</p>
{{ table([["a", "<1>"]], ("", "n"), numbers=true) }}
<img src="{{ data_uri(picture) }}">
{% endblock %}
"""
MARKDOWN = """\
{% from "parts.md.j2" import table %}
{{ text }}

{{ table(("", "n"), [["a", "<1>"], ["b", "2"]]) }}
"""


@pytest.fixture
def templates(tmp_path):
    (tmp_path / "own.html.j2").write_text(HTML)
    (tmp_path / "own.md.j2").write_text(MARKDOWN)
    return tmp_path


def test_html_is_escaped_and_holds_its_pictures(templates):
    page = render("own.html.j2", templates, title="<b>", text="x & y", picture=b"abc")
    assert "<title>&lt;b&gt;</title>" in page
    assert "<p>x &amp; y</p>" in page
    assert '<tr><th>a</th><td class="number">&lt;1&gt;</td></tr>' in page
    assert '<img src="data:image/png;base64,YWJj">' in page
    assert "<script" not in page  # without plots


def test_markdown_is_as_it_was_given(templates):
    page = render("own.md.j2", templates, text="x < y")
    assert page == "x < y\n\n|  | n |\n| --- | ---: |\n| a | <1> |\n| b | 2 |\n"


def test_a_value_that_is_not_given_is_an_error(templates):
    with pytest.raises(UndefinedError, match="text"):
        render("own.md.j2", templates)
