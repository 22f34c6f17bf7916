"""The results that docs/ publishes, and which studies make them."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Result:
    """What one study publishes.

    Attributes:
        target: of make, that carries it out; the name of the result.
        claim: what it is to show, in a sentence.
        study: its module in `studies`.
        data: its JSON, in `DOCS`.
        page: that is written with it, likewise.
        probe: function of the study that is its quick form, `module:function`; empty where its
            numbers are of the machine.
        made_in: folder in `OUT` that it writes to; empty where it writes into `DOCS`.
        copied: patterns of the files that are published from there, beside the JSON.
    """

    target: str
    claim: str
    study: str
    data: str
    page: str
    probe: str = ""
    made_in: str = ""
    copied: tuple[str, ...] = ()


RESULTS = (
    Result(
        "ground",
        "With a map it climbs and descends stairs, crosses gaps, walks stones and blocks.",
        "ground",
        "ground/summary.json",
        "ground/index.md",
        "ground.trial:probe",
    ),
    Result(
        "running",
        "It runs and turns, and takes pushes, tiles and slopes in a run.",
        "running",
        "running/summary.json",
        "running/index.md",
        "running.probe:probe",
    ),
    Result(
        "transfer",
        "Walks in MuJoCo are those in Drake, and as robust.",
        "transfer",
        "transfer/summary.json",
        "transfer/index.md",
        "transfer.cases:probe",
    ),
    Result(
        "robustness",
        "With random commands it takes pushes, slopes, tiles, ice and errors of the model.",
        "robustness",
        "robustness/summary.json",
        "robustness/index.md",
        "robustness.probe:probe",
    ),
    Result(
        "contact-study",
        "Contacts are felt within milliseconds, and what that brings.",
        "contact",
        "robustness/contact.json",
        "robustness/contact.md",
        "contact.ledges:probe",
    ),
    Result(
        "estimation",
        "It walks on an estimate of its state; how far that is off, and how sure it is of itself.",
        "estimation",
        "estimation/summary.json",
        "estimation/index.md",
        "estimation.walks:probe",
    ),
    Result(
        "smoother",
        "The filter is about as good as the best estimate of the whole walk.",
        "estimation.smoother",
        "estimation/smoother.json",
        "estimation/smoother.md",
        "estimation.walks:probe",
    ),
    Result(
        "zoo",
        "Robots that it was not made for walk, described from their models alone.",
        "zoo",
        "zoo/summary.json",
        "zoo/index.md",
        "zoo.trials:probe",
    ),
    Result(
        "surface-push",
        "A G1 that walks on its soles is pushed.",
        "zoo",
        "zoo/surface_push.json",
        "zoo/surface_push.json",
        "zoo.surface_push:probe",
    ),
    Result(
        "paper",
        "What the paper says of line contacts, the ECD and its plans holds here, or does not.",
        "paper",
        "paper/claims.json",
        "paper/index.html",
        "paper.parts:probe",
        "paper",
        ("index.html", "[!e]*.png", "exact.png"),
    ),
    Result(
        "models",
        "What models and horizons of the MPC bring after a push, and what errors cost.",
        "models",
        "models/summary.json",
        "models/index.md",
        "models.trial:probe",
    ),
    Result(
        "envelope",
        "How fast each model of the MPC walks and runs, in each direction.",
        "envelope",
        "paper/envelope.json",
        "paper/envelope.png",
        "envelope.probe:probe",
        "paper",
        ("envelope.png",),
    ),
    Result(
        "bench",
        "How fast its parts are, beside other packages.",
        "bench",
        "bench.json",
        "benchmarks.md",
        made_in="bench",
    ),
    Result(
        "qpbenchmark",
        "How solvers do on the programs of the MPC.",
        "qpbenchmark",
        "qpbenchmark.json",
        "qpbenchmark.md",
        made_in="qpbenchmark",
        copied=("qpbenchmark.md",),
    ),
    Result(
        "fault-injection",
        "Nothing that is broken, missing or interrupted ends in a traceback or in a wrong result.",
        "fault_injection",
        "reliability.json",
        "reliability.md",
        "fault_injection.bad_inputs:probe",
    ),
)
