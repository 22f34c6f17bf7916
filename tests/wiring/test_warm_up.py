"""Compiling before a run that somebody watches; tests/test_packaging.py carries it out."""

import pytest

from drake_linefoot.math import compiled
from drake_linefoot.wiring import warm_up as module
from drake_linefoot.wiring.warm_up import NOWHERE, warm_up


def test_it_does_nothing_when_machine_code_is_kept(monkeypatch):
    monkeypatch.setattr(module, "machine_code_is_kept", lambda: True)
    monkeypatch.setattr(module, "build_closed_loop", lambda *_: pytest.fail("simulated"))
    warm_up(pytest.fail)


def test_machine_code_is_kept_when_it_is_in_its_folder(monkeypatch, tmp_path):
    monkeypatch.setattr(compiled.config, "CACHE_DIR", str(tmp_path))
    assert not compiled.machine_code_is_kept()
    folder = tmp_path / f"kernels-{compiled._DIGEST}" / "math"
    folder.mkdir(parents=True)  # which an import makes
    assert not compiled.machine_code_is_kept()
    (folder / "kernels.dot-1.py311.1.nbc").touch()  # one function, of a run that broke off
    assert not compiled.machine_code_is_kept()
    compiled.keep_machine_code()
    assert compiled.machine_code_is_kept()


def test_where_nothing_can_be_kept_it_says_so_and_what_helps(monkeypatch):
    class EnoughError(Exception):
        pass

    def stop(scenario):
        raise EnoughError

    monkeypatch.setattr(compiled, "_folder", lambda: None)
    monkeypatch.setattr(module, "build_closed_loop", stop)
    said = []
    with pytest.raises(EnoughError):
        warm_up(said.append)
    assert said == [NOWHERE] and "NUMBA_CACHE_DIR" in NOWHERE
    compiled.keep_machine_code()  # does no harm


def test_interpreted_there_is_nothing_to_compile(monkeypatch, tmp_path):
    monkeypatch.setattr(compiled.config, "CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(compiled.config, "DISABLE_JIT", 1)
    assert compiled.machine_code_is_kept()
