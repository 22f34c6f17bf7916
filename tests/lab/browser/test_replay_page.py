"""The replay file in a browser."""

import pytest
from pydrake.geometry import Meshcat, MeshcatParams

from drake_linefoot.lab.visualization.replay import play, recording, run_title, write_replay
from tests.helpers.recorded_runs import short_run

OVERLAYS = {
    "capture point",
    "centre of pressure",
    "centre of mass",
    "estimated contact force",
    "estimated robot",
    "footholds",
    "friction cone",
    "planned footholds",
    "predicted centre of mass",
    "push",
    "support",
    "swing path",
    "true contact force",
}


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    """The replay of a log of 0.4 s."""
    meshcat, run = Meshcat(MeshcatParams(port=0)), short_run()
    with recording(meshcat):
        play(run, meshcat)
    path = tmp_path_factory.mktemp("replay") / "replay.html"
    write_replay(meshcat, path, run_title(run), run)
    return path


def children(page, *path):
    walk = "".join(f".children[{name!r}]" for name in path)
    return set(page.evaluate(f"Object.keys(viewer.scene_tree{walk}.children)"))


def test_it_opens_from_disk_plays_and_draws_everything(page, file, shot):
    requested = []
    page.on("request", lambda request: requested.append(request.url))
    page.goto(file.as_uri())
    page.wait_for_function("viewer.animator && viewer.animator.duration > 0", timeout=60_000)
    assert page.title().startswith("short, drake_linefoot ")
    assert page.evaluate("viewer.animator.duration") == pytest.approx(0.4, abs=1 / 32)
    assert "torso" in children(page, "drake", "visualizer", "mit_humanoid")
    assert children(page, "overlays") == OVERLAYS
    assert {url for url in requested if url.startswith("http")} == set()
    page.evaluate("viewer.animator.pause()")
    for time in (0.1, 0.39):
        page.evaluate(f"viewer.animator.seek({time})")
        page.wait_for_timeout(1500)
        shot(f"replay_{time}")


def test_time_moves_the_robot_and_shows_the_forces(page, file):
    page.goto(file.as_uri())
    page.wait_for_function("viewer.animator && viewer.animator.duration > 0", timeout=60_000)
    page.evaluate("viewer.animator.pause()")
    overlays = "viewer.scene_tree.children.overlays"
    arrow = f"{overlays}.children['true contact force'].children['left heel']"
    com = f"{overlays}.children['centre of mass'].children.now.object.position"
    seen = []
    for time in (0.05, 0.35):
        page.evaluate(f"viewer.animator.seek({time})")
        length = page.evaluate(f"{arrow}.children.shaft.object.scale.z")
        seen.append((page.evaluate(f"{com}.y"), length))
        assert page.evaluate(f"{arrow}.object.visible")
    assert abs(seen[1][0] - seen[0][0]) > 0.002  # the weight goes to the left foot
    assert all(0.05 < length < 0.6 for _, length in seen)


def test_every_overlay_has_a_switch(page, file):
    page.goto(file.as_uri())
    page.wait_for_function("viewer.animator && viewer.animator.duration > 0", timeout=60_000)
    switches = page.locator(".lf-legend label")
    assert set(switches.all_inner_texts()) == OVERLAYS
    visible = "viewer.scene_tree.children.overlays.children['capture point'].object.visible"
    for expected in (False, True):
        switches.get_by_text("capture point").click()
        assert page.evaluate(visible) is expected


def test_played_out_it_stays_at_its_end_and_space_plays_it_again(page, file):
    page.goto(file.as_uri())
    page.wait_for_function("viewer.animator && viewer.animator.duration > 0", timeout=60_000)
    page.get_by_text("0.40 of 0.40 s").wait_for()
    clock = "viewer.animator.actions[0].time"
    ended = f"!viewer.animator.playing && {clock} === viewer.animator.duration"
    page.wait_for_function(ended)
    assert float(page.locator(".lf-bar input").input_value()) == pytest.approx(0.4, abs=0.01)
    page.keyboard.press("Space")
    page.wait_for_function(f"viewer.animator.playing || {clock} < 0.4")
    page.wait_for_function(ended)


def test_led_elsewhere_as_it_plays_out_it_stays_there(page, file):
    page.goto(file.as_uri())
    page.wait_for_function("viewer.animator && viewer.animator.duration > 0", timeout=60_000)
    page.get_by_text("0.40 of 0.40 s").wait_for()
    page.evaluate("""() => {
        const slider = document.querySelector(".lf-bar input");
        viewer.animator.mixer.dispatchEvent({ type: "finished" });
        slider.value = 0.05;
        slider.dispatchEvent(new Event("input"));
    }""")
    page.get_by_text("0.05 of 0.40 s").wait_for()
    page.wait_for_timeout(200)
    assert page.get_by_text("0.05 of 0.40 s").is_visible()


def test_one_colour_means_one_thing(page, file):
    """Left is red and right is blue in the scene and the plots; no other line has these."""
    page.goto(file.as_uri())
    page.wait_for_function("viewer.animator && viewer.animator.duration > 0", timeout=60_000)
    colours = page.evaluate("""() => {
        const seen = {}, overlay = new Linefoot.Overlay([], null);
        for (const plot of Object.values(overlay.plots))
            plot.names.forEach((name, i) => { seen[`${plot.title} ${name}`] = plot.colours[i]; });
        return seen;
    }""")
    sides = {colours.pop("force left"), colours.pop("force right")}
    assert len(sides) == 2 and not sides & set(colours.values())


def test_the_play_bar_leads_to_a_time_and_the_status_follows(page, file, shot):
    page.goto(file.as_uri())
    page.wait_for_function("viewer.animator && viewer.animator.duration > 0", timeout=60_000)
    page.locator(".lf-bar input").fill("0.05")
    text = page.locator(".lf-bar")
    text.get_by_text("stand", exact=True).wait_for()
    for width, height in ((1280, 800), (1920, 950), (900, 560), (390, 844)):
        page.set_viewport_size({"width": width, "height": height})
        page.locator(".lf-bar input").fill("0.35")
        text.get_by_text("step", exact=True).wait_for()
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        shot(f"replay_bar_{width}")
    cells = page.locator(".lf-status tr").nth(1).locator("td").all_inner_texts()
    assert cells == ["commanded", "0.10", "0.00", "0.00"]
    page.keyboard.press("ArrowLeft")
    page.get_by_text("0.32 of 0.40 s").wait_for()
    page.keyboard.press("Space")
    page.wait_for_function("viewer.animator.playing")
