"""Signals while something runs whose results must not be lost."""

import os
import signal
import threading

import pytest

from drake_linefoot.lab.simulation.interruption import interruptions


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_the_first_one_is_kept_and_the_handlers_come_back(number):
    before = signal.default_int_handler
    outer = signal.signal(number, before)  # nohup has SIGHUP ignored
    try:
        with interruptions() as interrupted:
            assert not interrupted
            assert interrupted.status == 0
            os.kill(os.getpid(), number)
            assert interrupted
            assert interrupted.status == 128 + number
            assert signal.getsignal(number) == before  # so a second one acts as ever
        assert signal.getsignal(number) == before
    finally:
        signal.signal(number, outer)


def test_a_signal_that_is_ignored_stays_so():
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with interruptions() as interrupted:
            os.kill(os.getpid(), signal.SIGINT)
            assert not interrupted
        assert signal.getsignal(signal.SIGINT) == signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, before)


def test_a_thread_of_its_own_gets_none():
    seen = []

    def block():
        with interruptions() as interrupted:
            seen.append(bool(interrupted))

    thread = threading.Thread(target=block)
    thread.start()
    thread.join()
    assert seen == [False]
