"""The command as a process of its own: a Ctrl-C shows no traceback, whenever it comes."""

import signal
import subprocess
import sys

import pytest

# The command is one that is made up; where the process exits, another Ctrl-C comes.
COMMAND = """
import atexit, signal, sys, time
from drake_linefoot.__main__ import main
from drake_linefoot.lab import cli

def interrupt():
    signal.raise_signal(signal.SIGINT)

class Dropped:
    def __del__(self):
        {inside}

def command():
    {before}
    try:
        Dropped()
        time.sleep({wait})
    except KeyboardInterrupt:
        return 130
    atexit.register(interrupt)
    return 0

cli.main = command
sys.exit(main())
"""


def ended(before="pass", inside="pass", wait=0):
    """Return status and complaints of a command with something before it and in a destructor.

    It may not wait to the end of what it waits for, [s].
    """
    code = COMMAND.format(before=before, inside=inside, wait=wait)
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=40, check=False
    )
    return done.returncode, done.stderr


def test_a_ctrl_c_that_nobody_catches_is_one_line():
    assert ended(before="interrupt()") == (-signal.SIGINT, "linefoot: interrupted\n")


def test_a_ctrl_c_that_python_drops_comes_again():
    assert ended(inside="interrupt()", wait=50) == (130, "")


def test_a_ctrl_c_while_drake_loads_waits_for_it(tmp_path):
    (tmp_path / "pydrake.py").write_text(
        "import signal, sys, time\n"
        "signal.raise_signal(signal.SIGINT)\n"
        "time.sleep(0.1)\n"
        "print('loaded', file=sys.stderr)\n"
    )
    load = f"sys.path.insert(0, {str(tmp_path)!r}); import pydrake; time.sleep(50)"
    assert ended(before=load) == (-signal.SIGINT, "loaded\nlinefoot: interrupted\n")


def test_a_ctrl_c_that_is_ignored_stays_so():
    ignored = "signal.signal(signal.SIGINT, signal.SIG_IGN)\nsys.exit(main())"
    code = COMMAND.format(before="interrupt()", inside="pass", wait=0)
    code = code.replace("sys.exit(main())", ignored)
    done = subprocess.run([sys.executable, "-c", code], stderr=subprocess.PIPE, check=False)
    assert (done.returncode, done.stderr) == (0, b"")


def test_a_ctrl_c_at_the_exit_is_nothing_to_talk_about():
    assert ended() == (0, "")


@pytest.mark.parametrize("where", ["before", "inside"])
def test_another_error_is_shown_as_ever(where):
    status, said = ended(**{where: "raise ValueError('gait')"})
    assert status == (where == "before")
    assert "Traceback" in said and "ValueError: gait" in said


def test_the_version_is_looked_up_when_it_is_asked_for():
    """For what the package loads is loaded before the command can do anything about a Ctrl-C."""
    code = (
        "import sys, drake_linefoot as package; print('importlib.metadata' in sys.modules); "
        "print(package.__version__, '__version__' in vars(package)); package.no_such_name"
    )
    done = subprocess.run(
        [sys.executable, "-S", "-c", f"import sys; sys.path[:] = {sys.path!r}; {code}"],
        capture_output=True,
        text=True,
        check=False,
    )
    before, after = done.stdout.splitlines()
    assert before == "False"
    assert after.endswith(" True") and after[0].isdigit()
    assert "has no attribute 'no_such_name'" in done.stderr
