"""The compiled functions as plain Python: the same walk, for a debugger and to check the compiler.

And what docs/mathematics.md names is what runs: a link to a function that the walk does not call
would send its reader to the wrong place.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

WALK = """
import functools, importlib, json, re, sys
from types import FunctionType

from drake_linefoot.estimation.contact_parameters import CONSTRAINED, EstimatorParameters
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.mpc.parameters import ACTIVE_SET, MpcParameters
from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.scenario.disturbances import PushParameters
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop

called, text = set(), open(sys.argv[1], encoding="utf-8").read()
if text:  # returns None: asked once a call, not at each line
    sys.settrace(lambda frame, event, argument: called.add(frame.f_code))


def walk(end, **parts):
    segments = [Segment("stand", 0.02), Segment("walk", 1.0, walk=True, velocity=[0.3, 0.1])]
    loop = build_closed_loop(Scenario(segments=segments, **parts))
    loop.make_simulator().AdvanceTo(end)
    return loop


def code_of(dotted):
    module = dotted
    while True:
        module = module.rpartition(".")[0]
        try:
            found = importlib.import_module(module)
            break
        except ModuleNotFoundError:
            pass
    for name in dotted.removeprefix(module + ".").split("."):
        found = vars(found)[name]
    if isinstance(found, functools.cached_property):
        found = found.func
    if isinstance(found, property):
        found = found.fget
    if isinstance(found, type):  # classes that only hold data have no code of their own
        found = vars(found).get("__init__")
    if isinstance(found, FunctionType) and found.__code__.co_filename[0] != "<":
        return found.__code__
    return None


# It stands, shifts, steps, and is in flight; every foot slides, and early in the first swing it is
# pushed to the side of its stance foot.
push = PushParameters(time=0.45, duration=0.05, impulse=25.0, direction=1.6)
loop = walk(0.9, pushes=[push], gait=GaitParameters(flight=0.06, slip_min=1e-9))
if text:  # the other ways that a scenario can choose
    walk(0.03, estimator=EstimatorParameters(method=CONSTRAINED))
    walk(0.03, mpc=MpcParameters(solver=ACTIVE_SET))
    walk(0.03, mpc=MpcParameters(model="ecd"))
    walk(0.03, mpc=MpcParameters(model="srbm"))
    walk(0.03, robot=sys.argv[2])
    walk(0.03, estimation=True)
sys.settrace(None)
codes = {name: code_of(name) for name in re.findall(r"\\]\\[(drake_linefoot[\\w.]+)\\]", text)}
print(json.dumps({
    "linked": sorted(name for name, code in codes.items() if code is not None),
    "not called": sorted(name for name, code in codes.items() if code and code not in called),
    **{name: loop.recorder.samples(name).tolist() for name in ("q", "torque")},
}))
"""
MATHEMATICS = Path(__file__).resolve().parents[2] / "docs" / "mathematics.md"


def walked(page, soles, **environment):
    """What a process says; `soles` is a robot that stands on them."""
    done = subprocess.run(
        [sys.executable, "-c", WALK, str(page), str(soles)],
        env=os.environ | environment,
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def interpreted(sole_biped):
    return walked(MATHEMATICS, sole_biped.description.file, NUMBA_DISABLE_JIT="1")


@pytest.mark.slow
def test_compiled_functions_do_what_their_python_says(interpreted):
    compiled = walked(os.devnull, "", NUMBA_DISABLE_JIT="0")
    for name in ("q", "torque"):
        assert len(compiled[name]) > 890
        np.testing.assert_allclose(interpreted[name], compiled[name], rtol=0, atol=1e-6)


@pytest.mark.slow
def test_the_functions_of_the_mathematics_are_those_that_run(interpreted):
    assert len(interpreted["linked"]) > 50
    assert interpreted["not called"] == []
