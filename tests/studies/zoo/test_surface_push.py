"""Pushes of a robot on its soles: described from its model, swept, published."""

import json
from pathlib import Path

import pytest

from drake_linefoot.errors import InputError
from drake_linefoot.lab.sweep.file import load_sweep
from studies.common.stamp import STUDY, made_by
from studies.zoo import surface_push
from studies.zoo.robots import G1, make

SHORTER = {"duration: 2.0": "duration: 0.3", "time: 3.0": "time: 0.7", "[3.0, 6.0]": "[0.6, 0.8]"}


def test_without_the_package_it_says_what_to_install(monkeypatch):
    monkeypatch.setattr(surface_push, "published", lambda: ({}, ""))
    with pytest.raises(InputError, match=r"pip install -r requirements/zoo\.txt"):
        surface_push.described()


@pytest.mark.slow
def test_a_robot_is_described_pushed_and_published(monkeypatch, tmp_path):
    text = surface_push.SWEEP.read_text(encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    surface_push.SWEEP.parent.mkdir(parents=True)
    for long, short in SHORTER.items():
        assert long in text
        text = text.replace(long, short)
    surface_push.SWEEP.write_text(text, encoding="utf-8")
    model = make("soled_60", tmp_path)
    monkeypatch.setattr(surface_push, "published", lambda: ({G1: model}, "made up"))
    monkeypatch.setattr(surface_push, "sweep_of", load_sweep)  # not the one that is cached

    surface_push.surface_push(Path("published"), runs=1, workers=1)
    found = json.loads(Path("published", surface_push.JSON).read_text(encoding="utf-8"))
    assert found["made_with"][STUDY] == made_by("zoo")[STUDY]
    assert (found["runs"], found["probe"]) == ({"g1_surface_push": 1}, {})
    assert found["groups"]["g1_surface_push"]["upright"] == 1
    assert found["seconds"] > 0.0
    surface_push.surface_push(Path("published"), runs=1, workers=1)  # goes on: described anew
    again = json.loads(Path("published", surface_push.JSON).read_text(encoding="utf-8"))
    assert again == found
