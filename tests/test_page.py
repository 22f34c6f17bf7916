"""What objects show of themselves in a notebook: pages, drawings, a few facts."""

import html
import re
import sys
from pathlib import Path

import pytest

import drake_linefoot
from drake_linefoot import Scenario, build_closed_loop
from drake_linefoot.errors import InputError
from drake_linefoot.lab.visualization import replay, show
from drake_linefoot.page import Page
from tests.helpers.recorded_runs import short_run

TEXT = '<html><body class="a">1 < 2 &amp; "so"</body></html>'


def in_frame(page):
    """Return the page that a notebook has in its frame."""
    (source,) = re.findall(r'<iframe srcdoc="([^"]*)"', page._repr_html_())
    return html.unescape(source)


@pytest.fixture
def notebook(monkeypatch):
    """Let it look as in a notebook, where nothing is opened."""
    monkeypatch.setitem(sys.modules, "ipykernel", None)


def test_a_page_is_a_frame_and_a_file(tmp_path):
    page = Page("it.html", TEXT, 300)
    assert in_frame(page) == TEXT
    assert "height:300px" in page._repr_html_()
    assert page.save(tmp_path / "it.html").read_text(encoding="utf-8") == TEXT
    assert TEXT not in repr(page) and "it.html" in repr(page)


def test_a_script_opens_it_and_says_where_it_is(monkeypatch, capsys):
    opened = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.delitem(sys.modules, "ipykernel", raising=False)
    assert Page("it.html", TEXT).presented().html == TEXT
    (address,) = opened
    file = address.removeprefix("file://")
    assert Path(file).read_text(encoding="utf-8") == TEXT
    assert capsys.readouterr().err == f"{file}: open it in a browser\n"


def test_a_notebook_opens_nothing(notebook, monkeypatch, capsys):
    monkeypatch.setattr("webbrowser.open", None)
    Page("it.html", TEXT).presented()
    assert capsys.readouterr().err == ""


def test_a_run_has_its_report(notebook):
    page = short_run().report(height=700)
    assert page.height == 700 and page.name == "report.html"
    assert "<!DOCTYPE html>" in page.html[:100] and "centre of pressure" in page.html.lower()


def test_a_run_has_its_replay(notebook):
    page = short_run().show()
    assert page.name == "replay.html" and "Linefoot.replay(" in page.html
    assert in_frame(page) == page.html


def test_a_humanoid_is_shown(notebook, humanoid):
    page = humanoid.show()
    assert f"<title>{humanoid.description.name}</title>" in page.html
    assert len(page.html) > 2_000_000  # its meshes
    assert repr(humanoid).splitlines()[0] == "Humanoid 'MIT Humanoid'"
    assert "24.87 kg" in humanoid._repr_html_() and "line contact, 150 mm" in repr(humanoid)


def test_a_page_that_cannot_be_drawn_says_why(notebook, humanoid, monkeypatch):
    monkeypatch.setattr(show, "PROGRAM", (sys.executable, "-c", "raise SystemExit('no luck')"))
    with pytest.raises(drake_linefoot.errors.LinefootError, match="not drawn: no luck"):
        humanoid.show()
    monkeypatch.setattr(replay, "PROGRAM", (sys.executable, "-c", "raise SystemExit(3)"))
    with pytest.raises(drake_linefoot.errors.LinefootError, match="ended with status 3"):
        short_run().show()


def test_a_loop_is_drawn_whole_and_in_part(capfd):
    loop = build_closed_loop(Scenario())
    assert "loop.draw()" in repr(loop)
    whole, part = loop.draw(), loop.draw("controller")
    assert ">plant<" in whole._repr_svg_() and ">ecd_mpc<" in part._repr_svg_()
    assert repr(part) == "Picture of 'controller': draw(picture, folder) writes it"
    assert capfd.readouterr().err == ""  # of Fontconfig
    with pytest.raises(InputError, match="no such system; must be one of"):
        loop.draw("walk")


def test_dir_shows_what_is_for_users():
    names = dir(drake_linefoot)
    assert "walk" in names and "metadata" not in names
    assert [n for n in names if n.startswith("_")] == ["__doc__", "__file__", "__version__"]
