import dataclasses

import numpy as np
import pytest

from drake_linefoot.errors import InputError, LinefootError
from drake_linefoot.lab.simulation import recording
from drake_linefoot.lab.simulation.channels import MODES
from drake_linefoot.lab.simulation.recording import CHANNELS, Run
from drake_linefoot.statuses import Mode
from tests.helpers.recorded_runs import SIZES, make_run, short_run

TIME = np.arange(11) * 1e-3


def test_every_channel_says_its_unit_and_is_a_field():
    names = [field.name for field in dataclasses.fields(Run)]
    assert list(CHANNELS) == names[names.index("time") :]
    assert all(channel.unit for channel in CHANNELS.values())


def test_a_run_comes_back_from_its_file_as_it_was(tmp_path):
    run = short_run()
    run.save(tmp_path / "log.arrow")
    again = Run.load(tmp_path / "log.arrow")
    for field in dataclasses.fields(Run):
        before, after = getattr(run, field.name), getattr(again, field.name)
        if isinstance(before, np.ndarray):
            np.testing.assert_array_equal(after, before, err_msg=field.name)
        else:
            assert after == before, field.name


def test_a_run_is_read_from_its_folder_and_says_its_units(tmp_path):
    make_run(TIME).save(tmp_path / "log.arrow")
    run = Run.load(tmp_path)
    assert run.com.shape == (11, 3)
    assert (run.unit("com"), run.unit("rpy"), run.unit("torque")) == ("m", "rad", "N m")
    with pytest.raises(InputError, match=r"speed.*must be one of"):
        run.unit("speed")


def test_channels_name_and_measure_every_number():
    letters = dict(zip(SIZES, "abcfp", strict=True))
    sized = {size: (letter,) * SIZES[size] for size, letter in letters.items()}
    sizes = {name: len(names) for name, names in sized.items()}
    for name, channel in CHANNELS.items():
        names = channel.names(sized)
        assert tuple(len(axis) for axis in names) == channel.shape(sizes), name
        if names:
            assert len(channel.entry_units(len(names[-1]))) == len(names[-1]), name


def test_a_fall_comes_back_too(tmp_path):
    make_run(TIME, fell=True).save(tmp_path / "log.arrow")
    again = Run.load(tmp_path / "log.arrow")
    assert (again.fell, again.fall_time, again.fall_reason) == (True, 0.01, "torso low")


@pytest.mark.parametrize("content", [b"", b"nonsense", b"PK\x03\x04broken"])
def test_a_file_that_is_no_run_is_refused(tmp_path, content):
    (tmp_path / "log.arrow").write_bytes(content)
    with pytest.raises(InputError, match=r"log\.arrow"):
        Run.load(tmp_path / "log.arrow")


def test_a_missing_file_is_refused(tmp_path):
    with pytest.raises(InputError, match="cannot be read"):
        Run.load(tmp_path / "none.arrow")


def test_a_scenario_of_another_version_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(recording, "scenario_data", lambda scenario: {"colour": "red"})
    make_run(TIME).save(tmp_path / "log.arrow")
    with pytest.raises(LinefootError, match="colour"):
        Run.load(tmp_path / "log.arrow")


def test_yaw_goes_on_past_half_a_turn():
    yaw = np.linspace(0.0, 7.0, len(TIME))
    q = np.zeros((len(TIME), 25))
    q[:, 0], q[:, 3] = np.cos(0.5 * yaw), np.sin(0.5 * yaw)
    np.testing.assert_allclose(make_run(TIME, q=q).rpy[:, 2], yaw, atol=1e-12)


def test_modes_are_those_of_the_gait():
    """Logs hold their numbers: none may change."""
    assert MODES == ("stand", "shift", "swing", "double", "flight")
    assert [MODES[mode] for mode in Mode] == [mode.name.lower() for mode in Mode]
