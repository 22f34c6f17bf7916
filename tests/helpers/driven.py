"""Stands for the link of a live page: keeps what is shown, gives what is ordered."""

from drake_linefoot.lab.visualization.live import Live


class FakeLink:
    """What a page would be told, by kind; `ordered` waits to be read."""

    def __init__(self, files):
        self.files, self.shown, self.ordered = files, {}, []

    def show(self, kind, content):
        self.shown[kind] = content

    def orders(self):
        taken, self.ordered = self.ordered, []
        return taken


def fake_live(meshcat, files):
    """A page without a server."""
    return Live(meshcat, "", False, FakeLink(files))
