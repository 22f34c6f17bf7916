"""The results that docs/ publishes, and which studies make them."""

from dataclasses import dataclass
from pathlib import Path

DOCS, OUT = Path("docs"), Path("out")


@dataclass(frozen=True)
class Result:
    """What one study publishes.

    Attributes:
        target: of make, that carries it out; the name of the result.
        study: its module in `studies`.
        data: its JSON, in `DOCS`.
        page: that is written with it, likewise.
        probe: function of the study that is its quick form, `module:function`; empty where its
            numbers are of the machine.
        made_in: folder in `OUT` that it writes to; empty where it writes into `DOCS`.
        copied: patterns of the files that are published from there, beside the JSON.
    """

    target: str
    study: str
    data: str
    page: str
    probe: str = ""
    made_in: str = ""
    copied: tuple[str, ...] = ()


RESULTS = (
    Result("ground", "ground", "ground/summary.json", "ground/index.md", "ground.trial:probe"),
    Result("running", "running", "running/summary.json", "running/index.md", "running.probe:probe"),
    Result("transfer", "transfer", "transfer/summary.json", "transfer/index.md", "transfer:probe"),
    Result(
        "robustness",
        "robustness",
        "robustness/summary.json",
        "robustness/index.md",
        "robustness.probe:probe",
    ),
    Result(
        "contact-study",
        "contact",
        "robustness/contact.json",
        "robustness/contact.md",
        "contact.ledges:probe",
    ),
    Result(
        "estimation",
        "estimation",
        "estimation/summary.json",
        "estimation/index.md",
        "estimation.walks:probe",
    ),
    Result(
        "smoother",
        "estimation.smoother",
        "estimation/smoother.json",
        "estimation/smoother.md",
        "estimation.walks:probe",
    ),
    Result("zoo", "zoo", "zoo/summary.json", "zoo/index.md", "zoo.trials:probe"),
    Result(
        "paper",
        "paper",
        "paper/claims.json",
        "paper/index.html",
        "paper.parts:probe",
        "paper",
        ("index.html", "[!e]*.png", "exact.png"),
    ),
    Result(
        "envelope",
        "envelope",
        "paper/envelope.json",
        "paper/envelope.png",
        "envelope.probe:probe",
        "paper",
        ("envelope.png",),
    ),
    Result("bench", "bench", "bench.json", "benchmarks.md", made_in="bench"),
    Result(
        "qpbenchmark",
        "qpbenchmark",
        "qpbenchmark.json",
        "qpbenchmark.md",
        made_in="qpbenchmark",
        copied=("qpbenchmark.md",),
    ),
    Result(
        "fault-injection",
        "fault_injection",
        "reliability.json",
        "reliability.md",
        "fault_injection.bad_inputs:probe",
    ),
)
