"""A recording that is begun and ended on the driving page, and downloaded there."""

import threading
from pathlib import Path

from drake_linefoot.drive.session import Session
from drake_linefoot.errors import LinefootError
from drake_linefoot.simulation.recording import Run
from drake_linefoot.visualization.replay import draw_replay

LOG, REPLAY = "log.npz", "replay.html"


class Clip:
    """Records a part of a drive and writes it while the drive goes on.

    Attributes:
        note: what it is doing; empty when it does nothing.
        files: names of what can be downloaded.
    """

    def __init__(self, folder: Path) -> None:
        self._folder, self.note = folder, ""
        self.files: list[str] = []
        self._writing: threading.Thread | None = None

    def toggle(self, session: Session) -> None:
        """Begin to record, or end it and write what was recorded; nothing while it is written."""
        if self._writing is not None and self._writing.is_alive():
            return
        if not session.clip:
            session.begin_clip()
            self.note = "recording"
            return
        run = session.end_clip()
        if not len(run.time):
            self.note = "nothing was recorded"
            return
        self.note, self.files = "writing the recording", []
        self._writing = threading.Thread(target=self._write, args=(run,), daemon=True)
        self._writing.start()

    def _write(self, run: Run) -> None:
        log, replay = self._folder / LOG, self._folder / REPLAY
        try:
            run.save(log)
            self.files, self.note = [LOG], "drawing the replay"
            draw_replay(log, replay)
            self.files, self.note = [LOG, REPLAY], ""
        except LinefootError as error:
            self.note = str(error)
