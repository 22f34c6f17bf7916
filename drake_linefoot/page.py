"""A page that was made: a frame in a notebook, a file for any browser."""

import os
import sys
import tempfile
import webbrowser
from dataclasses import dataclass
from html import escape
from pathlib import Path

from drake_linefoot.files import write_file

HEIGHT = 480  # [px] in a notebook


@dataclass(frozen=True, repr=False)
class Page:
    """A page that needs no other file.

    Attributes:
        name: of its file, "replay.html".
        html: its text.
        height: of the frame in a notebook [px].
    """

    name: str
    html: str
    height: int = HEIGHT

    def save(self, path: str | Path) -> Path:
        """Write it; return the path.

        Raises:
            OutputError: it cannot be written.
        """
        write_file(path, self.html.encode())
        return Path(path)

    def presented(self) -> "Page":
        """Open it in a browser, but in a notebook, which shows what a cell returns; return it."""
        if "ipykernel" not in sys.modules:
            file = self.save(Path(tempfile.mkdtemp(prefix="linefoot-")) / self.name)
            print(f"{file}: open it in a browser", file=sys.stderr)
            if {"DISPLAY", "WAYLAND_DISPLAY"} & os.environ.keys() or sys.platform == "darwin":
                webbrowser.open(file.as_uri())
        return self

    def __repr__(self) -> str:
        """Return what it is; the text of the page is long."""
        return f"{self.name}, {len(self.html) / 1e6:.1f} MB: page.save(path) writes it"

    def _repr_html_(self) -> str:
        """Return a frame with the page in it, which Jupyter shows."""
        style = f"width:100%;height:{self.height}px;border:0"
        return f'<iframe srcdoc="{escape(self.html)}" style="{style}" allowfullscreen></iframe>'
