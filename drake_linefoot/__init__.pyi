"""What `from drake_linefoot import ...` gives, for editors and type checkers."""

from drake_linefoot.lab.scenario import Scenario as Scenario
from drake_linefoot.lab.scenario import Segment as Segment
from drake_linefoot.lab.simulation.recording import Run as Run
from drake_linefoot.lab.simulation.run import simulate as simulate
from drake_linefoot.lab.walk import walk as walk
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop as build_closed_loop
from drake_linefoot.robot.humanoid import load_humanoid as load_humanoid
from drake_linefoot.wiring.controller import build_controller as build_controller
from drake_linefoot.wiring.parameters import ControllerParameters as ControllerParameters
from drake_linefoot.wiring.without_simulator import Controller as Controller

__version__: str
