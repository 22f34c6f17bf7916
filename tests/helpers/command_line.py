"""The command line, run in this process."""

from drake_linefoot.lab import cli

SHORT_WALK = ("walk", "stand", "--duration", "0.1", "--no-replay")


def refuse(capsys, *words, main=cli.main, name="linefoot"):
    """Run a command that must be refused; return the one line it says."""
    status = main(words)
    out, err = capsys.readouterr()
    assert (status, out) == (2, "")
    assert err.startswith(f"{name}: ")
    assert err.count("\n") == 1
    return err
