"""The LeafSystem that draws the overlays while a loop is simulated."""

from pydrake.geometry import Meshcat
from pydrake.systems.framework import Context

from drake_linefoot.lab.plants.ground import Ground
from drake_linefoot.lab.simulation.recorder import Recorder
from drake_linefoot.lab.visualization.map_outlines import MapOutlines
from drake_linefoot.lab.visualization.overlays import PERIOD, OverlayPainter
from drake_linefoot.parts import KNOTS
from drake_linefoot.robot.humanoid import Humanoid


class Overlays(Recorder):
    """Draws contact forces, footholds, plans and the centre of mass into Meshcat.

    It is a `Recorder` that draws each sample, one every 1/32 s, and forgets it; so its ports are
    those of the recorder, and what is drawn live is what a replay of the log draws.
    """

    def __init__(
        self,
        humanoid: Humanoid,
        meshcat: Meshcat,
        friction: float,
        ground: Ground | None = None,
        knots: int = KNOTS,
        outlines: MapOutlines | None = None,
    ) -> None:
        """Declare ports and the event; as a `Recorder` and an `OverlayPainter` are made."""
        super().__init__(humanoid, PERIOD, knots)
        self.set_name("overlays")
        self._painter = OverlayPainter(humanoid, meshcat, friction, ground, outlines)

    def _sample(self, context: Context) -> None:
        super()._sample(context)
        for sample in self.samples(..., 1):  # none of a state that is not finite
            self._painter.draw(sample)
        self.keep_last(0)
