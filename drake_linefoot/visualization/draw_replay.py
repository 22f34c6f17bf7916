"""Drawing the replay of a run in a process of its own, away from what is simulated or kept.

Drake's Meshcat listens on a port even when nobody is to look, and ends its process at a malformed
message. `python -m drake_linefoot.visualization.draw_replay LOG PAGE TITLE` is that process.
"""

import signal
import subprocess
import sys
from pathlib import Path

from drake_linefoot.errors import LinefootError
from drake_linefoot.files import write_file
from drake_linefoot.simulation.quiet import quieten_drake
from drake_linefoot.simulation.recording import Run
from drake_linefoot.visualization.replay import play, recording, replay_html, run_title
from drake_linefoot.visualization.view import open_meshcat

LONGEST = 120.0  # [s] of a replay; of a longer run it is the end, for a page holds all of it
PROGRAM = (sys.executable, "-P", "-m", __spec__.name if __spec__ else __name__)


def draw_replay(log: str | Path, page: str | Path, title: str = "") -> None:
    """Draw a recorded run, or the last two minutes of it, as a page that plays by itself.

    Args:
        log: what `Run.load` takes.
        page: the file to write; all of it or nothing.
        title: of the page; else scenario and version.

    Raises:
        LinefootError: it was not drawn.
    """
    command = [*PROGRAM, str(log), str(page), title]
    done = subprocess.run(
        command, check=False, stdin=subprocess.DEVNULL, capture_output=True, text=True
    )
    if done.returncode:
        said = done.stderr.strip().splitlines()[-1:] or [_ending(done.returncode)]
        raise LinefootError(f"{page}: not drawn: {said[0]}")


def _ending(status: int) -> str:
    """Return how a process ended that said nothing."""
    if status >= 0:
        return f"its process ended with status {status}"
    return f"its process was ended by {signal.Signals(-status).name}"


def main(log: str, page: str, title: str) -> None:
    """Draw it in this process."""
    quieten_drake()
    run, meshcat = Run.load(log), open_meshcat()
    begin, title = max(0.0, float(run.time[-1]) - LONGEST), title or run_title(run)
    if begin:
        title += f", from {begin:g} s on"
    with recording(meshcat, begin):
        play(run, meshcat, realtime_rate=0.0, begin=begin)
    write_file(page, replay_html(meshcat, title, run, begin).encode())


if __name__ == "__main__":
    main(*sys.argv[1:])
