"""The kernels as plain Python: the same walk, for a debugger and as a check of the compiler."""

import json
import os
import subprocess
import sys

import numpy as np

WALK = """
import json
from drake_linefoot.scenario import Scenario, Segment
from drake_linefoot.wiring.closed_loop import build_closed_loop
segments = [Segment("stand", 0.02), Segment("walk", 1.0, walk=True, velocity=[0.3, 0.1])]
loop = build_closed_loop(Scenario(segments=segments))
loop.make_simulator().AdvanceTo(0.6)  # standing, shifting and in the first steps
print(json.dumps({name: loop.recorder.samples(name).tolist() for name in ("q", "torque")}))
"""


def walked(**environment):
    done = subprocess.run(
        [sys.executable, "-c", WALK],
        env=os.environ | environment,
        capture_output=True,
        text=True,
        check=True,
    )
    return json.loads(done.stdout)


def test_kernels_do_what_their_python_says():
    compiled, interpreted = walked(), walked(NUMBA_DISABLE_JIT="1")
    for name in ("q", "torque"):
        assert len(compiled[name]) > 590
        np.testing.assert_allclose(interpreted[name], compiled[name], rtol=0, atol=1e-6)
