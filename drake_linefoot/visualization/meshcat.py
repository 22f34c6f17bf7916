"""The Meshcat server that a browser, or a replay, gets its picture from."""

from pydrake.geometry import Meshcat, MeshcatParams

from drake_linefoot.errors import InputError, LinefootError


def open_meshcat(*, public: bool = False, port: int | None = None, stats: bool = False) -> Meshcat:
    """Open a Meshcat server.

    Args:
        public: whether other machines can reach it.
        port: of its page; None for the first free one.
        stats: whether it shows how fast it draws.

    Raises:
        InputError: the port is taken.
        LinefootError: there is no free port.
    """
    host = "*" if public else "localhost"
    try:
        return Meshcat(MeshcatParams(host=host, port=port, show_stats_plot=stats))
    except RuntimeError as error:
        if port is not None:
            raise InputError("--port", "", port, "is taken, or not allowed") from error
        raise LinefootError(f"Meshcat cannot open a port: {error}") from error
