"""Put machine code into the wheel, and check it: `make wheel`, which builds dist/ before.

    python tools/make_wheel.py dist/drake_linefoot-0.2.0-py3-none-any.whl

writes, beside that wheel, one for this release of Python on x86-64 Linux. It has what the first
walk compiles, made for x86-64-v3; where that does not fit (another processor, another Numba) it
compiles as the wheel without does. Then it is installed into an environment of its own and walks
there: nothing may be compiled, and the bits must be those of a walk with this processor's code.
"""

import base64
import csv
import hashlib
import io
import os
import platform
import subprocess
import sys
import sysconfig
import time
import zipfile
from pathlib import Path
from tempfile import TemporaryDirectory

from drake_linefoot.math.machine_code import COMPLETE, PREFIX, SHIPPED_CPU, SHIPPED_FEATURES

ROOT = Path(__file__).resolve().parents[1]
TARGET = {"NUMBA_CPU_NAME": SHIPPED_CPU, "NUMBA_CPU_FEATURES": SHIPPED_FEATURES}
# Machine code calls the C library by the names that every glibc has; Drake's wheels are newer.
PLATFORM = "manylinux_2_17_x86_64"
COMPILE = "from drake_linefoot.lab.wiring.closed_loop import warm_up; warm_up()"
# Says what was compiled, the bits of where it went, and when its first step was over.
WALK = """
import hashlib, time
from drake_linefoot.math.compiled import watched
from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
names, first = [], []
walk = [Segment("stand", 0.1), Segment("walk", 1.9, walk=True, velocity=[0.4, 0.1], turn_rate=0.3)]
look = lambda root: root.get_time() and not first and first.append(time.time())
with watched(names.append):
    run = simulate(build_closed_loop(Scenario(segments=walk)), look=look)
bits = hashlib.sha256(run.q.tobytes() + run.v.tobytes()).hexdigest()
print(len(names), bits, first[0], *names)
"""


def with_machine_code(wheel: str | Path, folder: Path) -> Path:
    """Write a wheel with the machine code of a folder beside the wheel without; return it.

    Raises:
        ValueError: the folder lacks what a walk needs, or the wheel is not for every platform.
    """
    wheel = Path(wheel)
    if not (folder / COMPLETE).is_file():
        raise ValueError(f"{folder} lacks machine code that a walk needs")
    python = f"cp{sys.version_info[0]}{sys.version_info[1]}"
    tag, every = f"{python}-none-{PLATFORM}", "py3-none-any"
    name, _, rest = wheel.name.rpartition(f"-{every}")
    if rest != ".whl":
        raise ValueError(f"{wheel.name} is not for {every}")
    made = wheel.with_name(f"{name}-{tag}.whl")
    with zipfile.ZipFile(wheel) as source:
        content = {entry: source.read(entry) for entry in source.namelist()}
        date = source.infolist()[0].date_time
    (record,) = (entry for entry in content if entry.endswith(".dist-info/RECORD"))
    about = record.replace("RECORD", "WHEEL")
    content[about] = content[about].replace(every.encode(), tag.encode())
    kept = [folder / COMPLETE, *folder.rglob("*.nbi"), *folder.rglob("*.nbc")]
    for file in sorted(kept):  # not what a process left that was ended while it wrote
        content[f"drake_linefoot/{folder.name}/{file.relative_to(folder)}"] = file.read_bytes()
    content[record] = content.pop(record)  # the last one, as in every wheel
    content[record] = _record(content, record)
    with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as target:
        for entry, data in content.items():
            info = zipfile.ZipInfo(entry, date)
            info.external_attr = 0o100644 << 16
            target.writestr(info, data, zipfile.ZIP_DEFLATED, 9)
    return made


def _record(content: dict[str, bytes], record: str) -> bytes:
    """Return the list of all files with their hashes, itself without."""
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    for entry, data in content.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        rows.writerow(
            (entry, "", "") if entry == record else (entry, f"sha256={digest}", len(data))
        )
    return text.getvalue().encode()


def environment_with(wheel: Path, home: Path) -> Path:
    """Install a wheel into a new environment with the dependencies of this one; return its Python.

    A .pth file lends them, written after the installation so that pip sees an empty environment. A
    .pth inside a lent folder is not read: no editable install comes along.
    """
    _run(sys.executable, "-m", "venv", "--without-pip", home)
    pip = (sys.executable, "-m", "pip", "--python", home / "bin" / "python", "install", "--quiet")
    _run(*pip, "--no-deps", "--no-index", wheel)
    paths = {"base": str(home), "platbase": str(home)}
    lent = {sysconfig.get_path("purelib"), sysconfig.get_path("platlib")}
    site = Path(sysconfig.get_path("purelib", vars=paths))
    (site / "lent.pth").write_text("\n".join(sorted(lent)), encoding="utf-8")
    return home / "bin" / "python"


def walk(python: Path | str, cwd: Path) -> tuple[list[str], str, float]:
    """Walk in a process: what it compiled, the bits of its states, and when its first step was."""
    start = time.time()
    _, bits, first, *names = _run(python, "-c", WALK, cwd=cwd).split()
    return names, bits, float(first) - start


def _run(*command: object, cwd: Path | None = None, **variables: str) -> str:
    """Run a command with nothing that points to the checkout; return its output."""
    without = ("PYTHONPATH", "NUMBA_CACHE_DIR", *TARGET)
    environment = {name: value for name, value in os.environ.items() if name not in without}
    words = [str(word) for word in command]
    done = subprocess.run(
        words, env=environment | variables, cwd=cwd, stdout=subprocess.PIPE, text=True, check=True
    )
    return done.stdout


def main(wheel: Path) -> None:
    """Write the wheel with machine code, and check it."""
    if (platform.system(), platform.machine()) != ("Linux", "x86_64"):
        print("machine code is put into wheels for Linux on x86_64 only")
        return
    with TemporaryDirectory() as folder:
        home = Path(folder)
        python = environment_with(wheel, home / "without")
        _run(python, "-c", COMPILE, cwd=home, NUMBA_CACHE_DIR=f"{home}/made", **TARGET)
        (made,) = (home / "made").glob(f"{PREFIX}*")
        full = with_machine_code(wheel, made)
        _, native, _ = walk(python, home)
        names, bits, first = walk(environment_with(full, home / "with"), home)
    if names:
        sys.exit(f"{full.name}: its walk compiles {len(names)} functions, {names[0]} for instance")
    if bits != native:
        sys.exit(f"{full.name}: its walk has other bits than with the code of this processor")
    size = full.stat().st_size / 1e6
    print(f"{full}: {size:.1f} MB, first step after {first:.1f} s, nothing compiled, same bits")


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve())
