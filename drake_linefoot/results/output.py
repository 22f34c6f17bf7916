"""The files a run leaves behind: all of them, or none."""

import json
import os
import tempfile
from functools import partial
from pathlib import Path

from drake_linefoot.errors import OutputError
from drake_linefoot.files import scratch_folder, writing
from drake_linefoot.results.metrics import compute_metrics
from drake_linefoot.simulation.mcap_log import MCAP, mcap_log
from drake_linefoot.simulation.recording import LOG, Run

REPLAY, PLOTS, METRICS, REPORT = "replay.html", "plots", "metrics.json", "report.html"
OURS = {REPLAY, LOG, MCAP, PLOTS, METRICS, REPORT}


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
        parent = target.parent
        while not parent.exists():
            parent = parent.parent
        with tempfile.TemporaryDirectory(dir=parent):
            pass


def write_outputs(run: Run, replay_html: str | None, out_dir: str | Path) -> None:
    """Write replay, report, log, `plots/*.png` and `metrics.json` into a folder.

    Everything is written into a folder beside it, which takes its place at the very end: on an
    error, or on Ctrl-C, an older result is still there and nothing half-written is.

    Args:
        run: what was recorded.
        replay_html: of `visualization.replay.replay_html`; None leaves the file out.
        out_dir: the folder; made with its parents when missing, replaced when there.

    Raises:
        OutputError: it cannot be written.
    """
    target = Path(out_dir).absolute()
    with writing(out_dir):
        _check_content(out_dir, target)
        target = target.resolve()  # a link stays, what it leads to is replaced
        target.parent.mkdir(parents=True, exist_ok=True)
        adopt = partial(_adopt, target)
        with scratch_folder(target.parent, f".{target.name}-", adopt) as scratch:
            new, old = scratch / "new", scratch / "old"
            new.mkdir()
            _write(run, replay_html, new)
            _swap(new, target, old)


def _check_content(path: str | Path, target: Path) -> None:
    """Raise OutputError when `target` exists and is not ours to replace."""
    if not target.exists():
        return
    if not target.is_dir():
        raise OutputError(path, "is a file")
    others = sorted(entry.name for entry in target.iterdir() if entry.name not in OURS)
    if others:
        shown = ", ".join(others[:3]) + (", ..." if len(others) > 3 else "")
        raise OutputError(path, f"holds other files ({shown}); name an empty or a new folder")


def _write(run: Run, replay_html: str | None, folder: Path) -> None:
    from drake_linefoot.results.plots_png import write_plots
    from drake_linefoot.results.report import report_html

    run.save(folder / LOG)
    (folder / MCAP).write_bytes(mcap_log(run))
    (folder / PLOTS).mkdir()
    write_plots(run, folder / PLOTS)
    metrics = compute_metrics(run)
    text = json.dumps(metrics, indent=2, allow_nan=False)
    (folder / METRICS).write_text(text + "\n", encoding="utf-8")
    links = {"replay": REPLAY, "log (numpy)": LOG, "log (MCAP)": MCAP, "metrics": METRICS}
    if replay_html is None:
        del links["replay"]
    else:
        (folder / REPLAY).write_text(replay_html, encoding="utf-8")
    (folder / REPORT).write_text(report_html(run, metrics, links), encoding="utf-8")


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
