"""How a scene is looked at: the Meshcat server, camera, light, lines on the ground."""

import secrets

import numpy as np
from pydrake.geometry import Meshcat, MeshcatParams, Rgba

from drake_linefoot.errors import LinefootError
from drake_linefoot.lab.plants.ground import Ground
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.scaling import round_number, units_of
from drake_linefoot.types import Array

# Lengths for the MIT Humanoid; another robot's are in its size.
CAMERA = (1.05, -1.3, 0.85)  # [m] in front of the robot, on its right
TARGET = (0.0, 0.0, 0.45)  # [m] what it looks at

Place = tuple[float, float, float]
LINES = "/ground_lines"
LINE_SPACING, LINE_HEIGHT = 0.5, 0.001  # [m]
LINES_AHEAD = 20  # on each side of the start
MOVED = ("/drake", "/overlays", LINES)  # what moves under a robot that is kept in view
LINE_COLOUR = Rgba(0.45, 0.47, 0.50, 1.0)

# Meshcat lights the origin only; a robot that walks away needs light from afar.
HIDDEN = (
    "/Axes",
    "/Grid",
    "/Lights/SpotLight",
    "/Lights/PointLightNegativeX",
    "/Lights/PointLightPositiveX",
)
SUN = (3.0, -4.0, 6.0)  # [m] where the light comes from
SUN_INTENSITY, AMBIENT_INTENSITY = 2.0, 1.2  # [-]


def open_meshcat() -> Meshcat:
    """Open a Meshcat server where nobody looks for one: on a random address of this machine.

    It answers everybody, and a malformed message ends the process. Linux has 16 million loopback
    addresses, each with its own ports; elsewhere it is 127.0.0.1. `live.live_page` opens one to
    look at.

    Raises:
        LinefootError: there is no free port.
    """
    hidden = ".".join(str(1 + secrets.randbelow(254)) for _ in range(3))
    for host in (f"127.{hidden}", "127.0.0.1"):
        try:
            return Meshcat(MeshcatParams(host=host, port=0, show_stats_plot=False))
        except RuntimeError as error:
            problem = error
    raise LinefootError(f"Meshcat cannot open a port: {problem}")


def set_up_view(
    meshcat: Meshcat,
    humanoid: Humanoid,
    ground: Ground | None = None,
    camera: tuple[Place, Place] = (CAMERA, TARGET),
) -> None:
    """Aim the camera at a robot that stands at the origin and looks along x.

    Args:
        meshcat: where.
        humanoid: the robot.
        ground: that lines are drawn on; without, the plane z = 0.
        camera: where it is and what it looks at [m], in the size of the robot.
    """
    m = units_of(humanoid)["m"]
    meshcat.SetCameraPose(*(m * np.array(place) for place in camera))
    for path in HIDDEN:
        meshcat.SetProperty(path, "visible", False)
    meshcat.SetProperty("/Lights/FillLight/<object>", "position", list(SUN))
    meshcat.SetProperty("/Lights/FillLight/<object>", "intensity", SUN_INTENSITY)
    meshcat.SetProperty("/Lights/FillLight/<object>", "castShadow", True)
    meshcat.SetProperty("/Lights/AmbientLight/<object>", "intensity", AMBIENT_INTENSITY)
    begin, end = _lines_on(ground or Ground(), *_ground_lines(round_number(LINE_SPACING * m)))
    meshcat.SetLineSegments(LINES, begin, end, 1.0, LINE_COLOUR)


def _ground_lines(spacing: float) -> tuple[Array, Array]:
    """Return x and y of begin and end of each piece [m], shape (2, n).

    Pieces are short: a line that runs on behind the camera is not drawn by every browser.
    """
    at = spacing * np.arange(-LINES_AHEAD, LINES_AHEAD + 1)
    along, across = (a.ravel() for a in np.meshgrid(at[:-1], at))
    further = along + spacing
    begin = np.hstack([[along, across], [across, along]])
    return begin, np.hstack([[further, across], [across, further]])


def _lines_on(ground: Ground, begin: Array, end: Array) -> tuple[Array, Array]:
    """Return lines on the ground, shape (3, n); those beyond it are left out.

    Ends are looked up a little inside of a line, for ground may change where it ends.
    """
    ends = []
    for here, there in ((begin, end), (end, begin)):
        inside = here + 1e-3 * (there - here)
        ends.append(np.vstack([here, ground.height(*inside) + LINE_HEIGHT]))
    known = np.isfinite(ends[0][2]) & np.isfinite(ends[1][2])
    return ends[0][:, known], ends[1][:, known]
