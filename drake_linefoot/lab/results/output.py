"""The files a run leaves behind: all of them, or none."""

import fcntl
import hashlib
import json
import os
import shutil
import stat
import tempfile
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

from drake_linefoot.errors import InputError, LinefootError, OutputError
from drake_linefoot.files import scratch_folder, write_file, writing
from drake_linefoot.lab.results.metrics import compute_metrics
from drake_linefoot.lab.simulation.log import read_log
from drake_linefoot.lab.simulation.mcap_log import MCAP, samples_for_one, write_mcap
from drake_linefoot.lab.simulation.recording import LOG, UNFINISHED, Run
from drake_linefoot.lab.visualization.drawing import Drawing
from drake_linefoot.lab.visualization.replay import begin_replay, draw_replay

OLD_LOG = "log.npz"  # that an older version wrote, which a new result replaces
REPLAY, PLOTS, METRICS, REPORT = "replay.html", "plots", "metrics.json", "report.html"
OLDER = ".old"  # behind the name of a folder whose samples nobody has written
LINKS = {"replay": REPLAY, "log (Arrow)": LOG, "log (MCAP)": MCAP, "metrics": METRICS}
OURS = {REPLAY, LOG, OLD_LOG, MCAP, PLOTS, METRICS, REPORT}


def check_output_dir(path: str | Path) -> None:
    """Make sure that a result can be written to `path`, before anything is simulated.

    The folder need not exist. One that does must be empty or hold an older result and nothing
    else, because a new result takes the place of the whole folder.

    Raises:
        OutputError: it cannot.
    """
    target = Path(path).absolute()
    with writing(path):
        _check_content(path, target)
        _check_content(*_unfinished(path), {LOG})
        parent = target.parent
        while not parent.exists():
            parent = parent.parent
        with tempfile.TemporaryDirectory(dir=parent):
            pass


@contextmanager
def reserved(path: str | Path) -> Iterator[None]:
    """Keep other runs of this user and machine from writing to `path` inside the `with` block.

    Raises:
        OutputError: another run does.
    """
    target = os.path.realpath(path)  # which takes a loop of links as well
    name = hashlib.sha256(os.fsencode(target)).hexdigest()[:16]
    lock = Path(tempfile.gettempdir()) / f"linefoot-{os.getuid()}-{name}.lock"
    with writing(path):
        held = os.open(lock, os.O_CREAT | os.O_RDWR | os.O_NOFOLLOW, 0o600)
    try:
        try:
            fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise OutputError(path, "another run writes there") from error
        yield
    finally:
        os.close(held)


@contextmanager
def unfinished(path: str | Path, say: Callable[[str], None]) -> Iterator[Path]:
    """Give a folder for the samples of a run that will be written to `path`: `PATH.part`.

    If there are samples in it, it stays until `forget_unfinished`. Samples that an older run has
    left there are kept, in `PATH.old.part`; those that were kept before are removed.

    Args:
        path: of the result.
        say: called with a line about what was there.

    Raises:
        OutputError: it cannot be made, or is not ours to replace.
    """
    shown, part = _unfinished(path)
    kept_as, kept = _unfinished(f"{Path(path)}{OLDER}")
    with writing(shown):
        _check_content(shown, part, {LOG})
        if _has_samples(part):
            _check_content(kept_as, kept, {LOG})
            gone = ", in place of those of another one" if kept.exists() else ""
            shutil.rmtree(kept, ignore_errors=True)
            part.rename(kept)
            say(f"samples of a run that was never written are kept in {kept_as}{gone}")
        shutil.rmtree(part, ignore_errors=True)
        part.mkdir(parents=True)
    try:
        yield part
    finally:
        if not _has_samples(part):
            shutil.rmtree(part, ignore_errors=True)


def _has_samples(part: Path) -> bool:
    """Whether there is a log with samples; one that cannot be read may have some."""
    if not (part / LOG).exists():
        return False
    try:
        return read_log(part / LOG).count > 0
    except InputError:
        return (part / LOG).stat().st_size > 0


def forget_unfinished(path: str | Path) -> None:
    """Remove the folder of `unfinished`, once the run is written."""
    shutil.rmtree(_unfinished(path)[1], ignore_errors=True)


def _unfinished(path: str | Path) -> tuple[str, Path]:
    """Return the folder of `unfinished` as it is shown, and where it is."""
    target = Path(path).absolute()
    return f"{path}{UNFINISHED}", target.with_name(target.name + UNFINISHED)


def write_outputs(
    run: Run, out_dir: str | Path, replay: bool = False, rate: float | None = None
) -> dict[str, Any]:
    """Write report, logs, `plots/*.png` and `metrics.json` into a folder.

    Everything is written into a folder beside it, which takes its place at the very end: on an
    error before, an older result is still there and nothing half-written is. But a run is
    not lost because it cannot be shown: when log and metrics are written and the rest fails, or
    Ctrl-C ends it, they take the place all the same, alone. So they do of a run without a sample.

    Args:
        run: what was recorded.
        out_dir: the folder; made with its parents when missing, replaced when there.
        replay: whether `add_replay` comes next, so that the report leads to it.
        rate: of the samples in `log.arrow` [Hz], see `write_mcap`; every one without. Everything
            else is made of all samples.

    Returns:
        The metrics.

    Raises:
        OutputError: it cannot be written.
    """
    target = Path(out_dir).absolute()
    with writing(out_dir):
        _check_content(out_dir, target)
        target = Path(os.path.realpath(target))  # a link stays, what it leads to is replaced
        target.parent.mkdir(parents=True, exist_ok=True)
        adopt = partial(_adopt, target)
        with scratch_folder(target.parent, f".{target.name}-", adopt) as scratch:
            new, old = scratch / "new", scratch / "old"
            new.mkdir()
            metrics = _write_data(run, new, rate)
            if len(run.time):
                try:
                    _write_pictures(run, metrics, new, replay)
                except OSError:
                    raise
                except BaseException:  # a Ctrl-C, too
                    _keep_data(new)
                    _swap(new, target, old)
                    raise
            _swap(new, target, old)
    return metrics


@contextmanager
def replay_begun(out_dir: str | Path) -> Iterator[Drawing | None]:
    """Draw the replay of a run in the `with` block, while its other files are written.

    Yields:
        What `add_replay` takes; None where `unfinished` has no samples to draw it from.
    """
    if not _has_samples(part := _unfinished(out_dir)[1]):
        yield None
        return
    with tempfile.TemporaryDirectory() as folder, begin_replay(part, Path(folder, REPLAY)) as begun:
        yield begun


def add_replay(
    run: Run, metrics: dict[str, Any], out_dir: str | Path, begun: Drawing | None = None
) -> None:
    """Put the replay of a run into the folder that `write_outputs` wrote.

    Args:
        run: what was recorded.
        metrics: of it.
        out_dir: the folder.
        begun: what `replay_begun` yields; without, it is drawn now.

    Raises:
        LinefootError: it cannot be drawn or written; the rest of the folder is whole.
    """
    folder = Path(out_dir)
    try:
        if begun is None:
            draw_replay(folder, folder / REPLAY)
        else:
            begun.wait(folder / REPLAY)
            with writing(folder / REPLAY):
                shutil.move(begun.page, folder / REPLAY)
    except LinefootError:
        write_file(folder / REPORT, _report(run, metrics, replay=False))
        raise


def _check_content(path: str | Path, target: Path, ours: Collection[str] = OURS) -> None:
    """Raise OutputError when `target` exists and is not ours to replace."""
    if Path(os.path.realpath(target)) == Path.cwd():
        raise OutputError(path, "is the current folder, which cannot be replaced")
    try:
        kind = target.stat().st_mode
    except FileNotFoundError:
        return
    if not stat.S_ISDIR(kind):
        raise OutputError(path, "is a file")
    others = sorted(entry.name for entry in target.iterdir() if entry.name not in ours)
    if others:
        shown = ", ".join(others[:3]) + (", ..." if len(others) > 3 else "")
        raise OutputError(path, f"holds other files ({shown}); name an empty or a new folder")


def _write_data(run: Run, folder: Path, rate: float | None) -> dict[str, Any]:
    """Write log and metrics; return the metrics."""
    step = 1 if rate is None else samples_for_one(run.time, rate)
    run.save(folder / LOG, step)
    metrics = compute_metrics(run)
    text = json.dumps(metrics, indent=2, allow_nan=False)
    (folder / METRICS).write_text(text + "\n", encoding="utf-8")
    return metrics


def _keep_data(folder: Path) -> None:
    """Remove what is not log and metrics, and may be half-written."""
    for entry in folder.iterdir():
        if entry.is_dir():
            shutil.rmtree(entry)
        elif entry.name not in (LOG, METRICS):
            entry.unlink()


def _write_pictures(run: Run, metrics: dict[str, Any], folder: Path, replay: bool) -> None:
    """Write what shows a run."""
    from drake_linefoot.lab.results.plots_png import write_plots

    with (folder / MCAP).open("wb") as file:
        write_mcap(run, file)
    (folder / PLOTS).mkdir()
    write_plots(run, folder / PLOTS)
    (folder / REPORT).write_bytes(_report(run, metrics, replay))


def _report(run: Run, metrics: dict[str, Any], replay: bool) -> bytes:
    from drake_linefoot.lab.results.report import report_html

    links = {words: file for words, file in LINKS.items() if replay or file != REPLAY}
    return report_html(run, metrics, links).encode()


def _adopt(target: Path, scratch: Path) -> None:
    """Let a result take its place that a killed process had written but not yet put there."""
    if not target.exists() and (scratch / "old").exists():
        os.rename(scratch / ("new" if (scratch / "new").exists() else "old"), target)


def _swap(new: Path, target: Path, old: Path) -> None:
    """Put `new` where `target` is; `old` takes what was there, and gives it back on failure."""
    try:
        if target.exists():
            os.rename(target, old)
        os.rename(new, target)
    finally:
        if old.exists() and not target.exists():
            os.rename(old, target)
