import base64
import re

import msgpack
import pytest
from pydrake.geometry import Meshcat, MeshcatParams

from drake_linefoot import __version__
from drake_linefoot.errors import InputError, OutputError
from drake_linefoot.lab.visualization import replay
from drake_linefoot.lab.visualization.replay import (
    play,
    recording,
    replay_html,
    run_title,
    write_replay,
)
from tests.helpers.recorded_runs import short_run


@pytest.fixture(scope="module")
def meshcat():
    return Meshcat(MeshcatParams(port=0))


@pytest.fixture(scope="module")
def page(meshcat):
    with recording(meshcat):
        play(short_run(), meshcat)
    return replay_html(meshcat, "walk <1>")


def test_playing_shows_robot_and_overlays(meshcat, page):
    assert meshcat.HasPath("/drake/visualizer/mit_humanoid/torso")
    assert meshcat.HasPath("/overlays/footholds/right/0")
    assert meshcat.HasPath("/overlays/true contact force/left heel/shaft")


def test_a_recording_has_every_picture_and_plays_by_itself(meshcat, page):
    animation = meshcat.get_mutable_recording()
    assert animation.frames_per_second() == 32.0
    assert animation.autoplay()
    assert animation.loop_mode() == animation.LoopMode.kLoopRepeat


def test_the_page_is_one_file_with_a_title(page):
    assert page.count("<title>") == 1
    assert "<title>walk &lt;1&gt;</title>" in page
    assert "</body>" in page[-30:]
    assert not re.search(r"<(script|link|img)[^>]*(src|href)=.(http|//)", page)
    assert len(page) < 5e6


def test_its_title_names_scenario_and_version():
    assert run_title(short_run()) == f"short, drake_linefoot {__version__}"


def test_it_is_written_or_refused(meshcat, page, tmp_path):
    write_replay(meshcat, tmp_path / "replay.html", "walk <1>")
    assert (tmp_path / "replay.html").read_text(encoding="utf-8") == page
    with pytest.raises(OutputError, match="none/replay"):
        write_replay(meshcat, tmp_path / "none" / "replay.html")


def test_an_error_ends_the_recording(meshcat):
    with pytest.raises(KeyError), recording(meshcat):
        raise KeyError
    with recording(meshcat):  # a second one can begin
        pass


def frames(page):
    """The first and the last frame of the animation in a page."""
    blobs = map(base64.b64decode, re.findall(r"base64,([A-Za-z0-9+/=]{20,})", page))
    (command,) = [msgpack.unpackb(b) for b in blobs if b"set_animation" in b[:200]]
    clips = [animation["clip"] for animation in command["animations"]]
    times = [k["time"] for c in clips for track in c["tracks"] for k in track["keys"]]
    return min(times), max(times)


def test_a_replay_of_the_end_begins_there(page):
    own = Meshcat(MeshcatParams(port=0))
    with recording(own, 0.2):
        play(short_run(), own, 0.2)
    assert frames(page) == (0, 12)  # 0.4 s at 32 Hz
    assert frames(replay_html(own)) == (0, 6)


def test_a_long_run_is_drawn_from_its_last_minutes_on(tmp_path, monkeypatch):
    monkeypatch.setattr(replay, "LONGEST", 0.1)
    short_run().save(tmp_path / "log.arrow")
    replay.main(str(tmp_path), str(tmp_path / "replay.html"), "")
    page = (tmp_path / "replay.html").read_text(encoding="utf-8")
    assert frames(page) == (0, 3)
    assert "<title>short, drake_linefoot " in page and ", from 0.3 s on</title>" in page


def test_a_replay_goes_on_for_two_minutes_from_where_it_begins(monkeypatch):
    monkeypatch.setattr(replay, "LONGEST", 0.125)
    own, run = Meshcat(MeshcatParams(port=0)), short_run()
    page = replay.draw(run, own, 0.1)
    assert frames(page) == (0, 4)
    assert ", from 0.1 s on</title>" in page
    shown = replay.replay_data(run, replay.robot_of(run), 0.1)
    assert (shown["begin"], shown["time"][-1]) == (0.1, 0.125)
    with pytest.raises(InputError, match="--begin = 9"):
        replay.draw(run, own, 9.0)
