"""Files that are no scenarios, robots, sweeps, recordings or journals, or only just not any more.

Each is a whole one with a few changes: entries replaced by odd values, bytes flipped, the end cut
off. It is taken, or refused by the package's own error of one line within seconds.
"""

import copy
import json
import sqlite3
import tempfile
import time as clock
from collections.abc import Callable
from contextlib import closing
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from drake_linefoot.checks import plain
from drake_linefoot.errors import InputError
from drake_linefoot.lab.results.metrics import compute_metrics
from drake_linefoot.lab.results.tables import log_table
from drake_linefoot.lab.scenario.load import load_scenario
from drake_linefoot.lab.simulation.log import LogFile
from drake_linefoot.lab.simulation.recording import CHANNELS, LOG, Run
from drake_linefoot.lab.sweep.file import load_sweep
from drake_linefoot.lab.sweep.journal import JOURNAL, open_journal
from drake_linefoot.lab.sweep.rows import COLUMNS
from drake_linefoot.lab.sweep.statistics import summarize_groups
from drake_linefoot.lab.sweep.table import write_table
from drake_linefoot.resources import models_dir
from drake_linefoot.robot.humanoid import load_humanoid
from studies.common.stamp import Probed
from studies.fault_injection.tally import LONGEST, SLOW, Tally

PROBED = 20  # files of each kind
SAMPLES, SIZES = 11, {"nq": 25, "nv": 24, "na": 18, "nw": 5, "nc": 2}
STRANGE: tuple[Any, ...] = (None, 0, -1.5, "", "x", [], ["a", 1], {}, [None] * 18, 2**70)
NUMBERS = (0, -1, 1, 2**70, 1e300, -1e300, 1e-300, 1e9, float("nan"), float("inf"), 0.5, -0.5, 10.0)
WORDS = ("", "x", "0 nan 0", "1e-3", "../..", "\x00", "$", "left", "ecd", "\u202e", "a" * 5000)
ODD: tuple[Any, ...] = (
    *(NUMBERS + WORDS),
    *(None, True, [], {}, [[]], [1.0] * 3, {"a": 1}, [None] * 50, {1: 2}),
)
MODEL = models_dir() / "mit_humanoid" / "mit_humanoid.urdf"
ROBOT = yaml.safe_load(MODEL.with_suffix(".yaml").read_text(encoding="utf-8"))
SWEEP = {
    "name": "odd",
    "scenario": "stand",
    "runs": 3,
    "groups": [{"name": "a", "set": {"gait.com_height": 0.62}}, {"name": "b"}],
    "sample": {
        "perturbation.joint_velocity": {"uniform": [0.0, 0.5]},
        "pushes": {"choice": [[], [{"impulse": 3.0}]]},
        "ground.friction": {"normal": [0.7, 0.1], "clip": [0.5, 0.9]},
    },
}
Make = Callable[[np.random.Generator, Path], Path]


def places(data: Any) -> list[tuple[Any, Any]]:
    """Return every container in plain data with each of its keys."""
    if not isinstance(data, dict | list):
        return []
    keys = list(data) if isinstance(data, dict) else range(len(data))
    return [(data, key) for key in keys] + [p for key in keys for p in places(data[key])]


def changed(rng: np.random.Generator, data: Any) -> Any:
    """Return plain data with one to three entries replaced, dropped or added."""
    data = copy.deepcopy(data)
    for _ in range(rng.integers(1, 4)):
        spots = places(data)
        container, key = spots[rng.integers(len(spots))]
        way = rng.integers(8)
        if way == 0:
            del container[key]
        elif way == 1 and isinstance(container, dict):
            container[str(rng.integers(100))] = copy.deepcopy(ODD[rng.integers(len(ODD))])
        else:
            container[key] = copy.deepcopy(ODD[rng.integers(len(ODD))])
        if not places(data):
            break
    return data


def garbled(rng: np.random.Generator, content: bytes) -> bytes:
    """Return bytes with a few flipped, or without the end."""
    some = bytearray(content)
    for at in rng.integers(len(some), size=rng.integers(1, 5)):
        some[at] ^= 1 << int(rng.integers(8))
    return bytes(some[: rng.integers(len(some))] if rng.random() < 0.3 else some)


def written(rng: np.random.Generator, file: Path, data: Any) -> Path:
    """Write plain data with changes; now and then its text is garbled as well."""
    text = yaml.dump(changed(rng, data), Dumper=yaml.CSafeDumper, allow_unicode=True).encode()
    file.write_bytes(garbled(rng, text) if rng.random() < 0.2 else text)
    return file


def scenario(rng: np.random.Generator, folder: Path) -> Path:
    """Write an odd scenario."""
    return written(rng, folder / "scenario.yaml", _whole_scenario())


@cache
def _whole_scenario() -> Any:
    return json.loads(json.dumps(plain(load_scenario("walk"))))  # numbers of no robot


def sweep(rng: np.random.Generator, folder: Path) -> Path:
    """Write an odd sweep."""
    return written(rng, folder / "sweep.yaml", SWEEP)


def robot(rng: np.random.Generator, folder: Path) -> Path:
    """Write an odd description of a robot, or an odd model, or both."""
    words = MODEL.read_text(encoding="utf-8").split('"')  # every second one is an attribute
    for _ in range(rng.integers(0, 3)):
        odd = (*WORDS, *map(str, NUMBERS))
        words[2 * int(rng.integers(len(words) // 2)) + 1] = odd[rng.integers(len(odd))]
    text = '"'.join(words).encode()
    model = folder / "model.urdf"
    model.write_bytes(garbled(rng, text) if rng.random() < 0.2 else text)
    data, file = {**ROBOT, "model": model.name}, folder / "robot.yaml"
    if rng.random() < 0.5:
        return written(rng, file, data)
    file.write_text(yaml.safe_dump(data), encoding="utf-8")
    return file


def recording(rng: np.random.Generator, folder: Path) -> Path:
    """Write an odd recording."""
    file, shapes = folder / LOG, {n: c.shape(SIZES) for n, c in CHANNELS.items()}
    begin: dict[str, Any] = {"version": "0", "scenario": {"name": "a"}}
    begin |= {"joint_names": [f"j{i}" for i in range(18)], "effort_limits": [1.0] * 18}
    end: dict[str, Any] = {"fell": False, "fall_time": None, "fall_reason": "", "wall_seconds": 1.0}
    if rng.random() < 0.5:
        name, way = str(rng.choice(list(shapes))), rng.integers(3)
        if way:
            shapes[name] = (*shapes[name], 2) if way == 1 else shapes[name][1:]
        else:
            del shapes[name]
    if rng.random() < 0.3:
        said = begin if rng.random() < 0.5 else end
        said[str(rng.choice(list(said)))] = STRANGE[rng.integers(len(STRANGE))]
    dtype = np.dtype([(name, np.float64, shape) for name, shape in shapes.items()])
    log, rows = LogFile(file, dtype, CHANNELS, begin), np.zeros(SAMPLES, dtype)
    if "q" in shapes and shapes["q"] == (SIZES["nq"],):
        rows["q"][:, 0] = rng.choice([1.0, 1.0, 1.0, 0.0, np.nan])
    if "time" in shapes and not shapes["time"]:
        rows["time"] = np.arange(SAMPLES) * float(rng.choice([1e-3, 0.0, np.nan, 1e-300, 10.0]))
    log.append(rows)
    log.end(end)
    if rng.random() < 0.6:
        file.write_bytes(garbled(rng, file.read_bytes()))
    return file


def journal(rng: np.random.Generator, folder: Path) -> Path:
    """Write the journal of a sweep with an odd value in a row, or without a column."""
    file = folder / JOURNAL
    file.unlink(missing_ok=True)
    names = [*COLUMNS, "sampled"]
    row = {"group": "a", "index": 0, "seed": 0, "cause": "upright", "error": "", "attempts": 1}
    row |= {"worker": "", "sampled": "{}"}
    values = [row.get(name) for name in names]
    where = int(rng.integers(len(names)))
    odd = ODD[rng.integers(len(ODD))]
    fits = odd is None or (isinstance(odd, int | float | str) and abs_of(odd) < 2**63)
    values[where] = odd if fits else json.dumps(odd, default=str)
    if rng.random() < 0.2:
        del names[where], values[where]
    with closing(sqlite3.connect(file)) as made:
        made.execute("CREATE TABLE sweep (name, fingerprint, made_with)")
        made.execute("INSERT INTO sweep VALUES ('a', 'b', '{}')")
        made.execute(f"CREATE TABLE runs ({', '.join(map(repr, names))})")
        made.execute(f"INSERT INTO runs VALUES ({', '.join('?' * len(names))})", values)
        made.commit()
    if rng.random() < 0.3:
        file.write_bytes(garbled(rng, file.read_bytes()))
    return file


def abs_of(value: float | str) -> float:
    """Return the size of a number; 0 of a text."""
    return 0.0 if isinstance(value, str) else abs(value)


def read_journal(file: Path) -> None:
    """Read a journal, and make of its rows what a sweep makes of them."""
    with open_journal(file.parent, {"name": "a", "fingerprint": "b", "made_with": {}}, False) as it:
        rows = it.rows()
    json.dumps(summarize_groups({"a": rows}), allow_nan=False)
    write_table(file.with_suffix(".parquet"), rows, {}, {})


def use_recording(file: Path) -> None:
    """Read a recording, and all that is made of it."""
    run = Run.load(file)
    for name in CHANNELS:
        getattr(run, name)
    json.dumps(compute_metrics(run), allow_nan=False)
    log_table(file.parent)


KINDS: dict[str, tuple[Make, Callable[[Path], object], int]] = {  # and how many of each
    "scenarios": (scenario, load_scenario, 6000),
    "robots": (robot, load_humanoid, 2500),
    "sweeps": (sweep, load_sweep, 1000),
    "recordings": (recording, use_recording, 8000),
    "journals": (journal, read_journal, 3000),
}


def bad_inputs(kind: str, count: int, seed: int, folder: Path) -> Tally:
    """Try so many odd files of one of `KINDS`, written into `folder`, with seeds from `seed` on."""
    make, load, _ = KINDS[kind]
    tally = Tally(kind)
    for number in range(seed, seed + count):
        file = make(np.random.default_rng([number, len(kind)]), folder)
        start = clock.process_time()
        try:
            load(file)
            end, problem = "taken", ""
        except InputError as error:
            message = str(error)
            fits = "\n" not in message and len(message) < LONGEST + 3 * len(str(folder))
            end, problem = "refused", "" if fits else f"{number}: message of {len(message)}"
        except (Exception, SystemExit) as error:  # SystemExit is what Drake's assertions are
            end, problem = "broke", f"{number}: {type(error).__name__}: {error}"[:300]
        if clock.process_time() - start > SLOW:
            problem = f"{number}: took {clock.process_time() - start:.0f} s"
        tally.count(end, problem)
    return tally


def probe() -> dict[str, Probed]:
    """Return a quick form of the study: how many odd files are answered wrongly."""
    with tempfile.TemporaryDirectory() as folder:
        tallies = {kind: bad_inputs(kind, PROBED, 0, Path(folder)) for kind in KINDS}
    return {kind: Probed(float(len(tally.wrong)), 0.0) for kind, tally in tallies.items()}
