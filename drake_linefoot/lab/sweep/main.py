"""`linefoot sweep`: carries out what is missing of a sweep, and writes its results."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from drake_linefoot.errors import LinefootError, OutputError, legible
from drake_linefoot.fields import unit_of
from drake_linefoot.files import write_file, writing
from drake_linefoot.lab.pool import Done, Pool
from drake_linefoot.lab.results.judge import upright
from drake_linefoot.lab.results.provenance import differences, made_with
from drake_linefoot.lab.results.tables import number_table
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.scenario.paths import parts_of
from drake_linefoot.lab.sweep.cluster import existing_cluster, run_on_cluster
from drake_linefoot.lab.sweep.file import Sweep, load_sweep
from drake_linefoot.lab.sweep.jobs import Job, Key, fingerprint, header_of, jobs, sampled_paths
from drake_linefoot.lab.sweep.journal import JOURNAL, OLDER, Journal, open_journal
from drake_linefoot.lab.sweep.page import NOTHING, RATES, rate_row, sweep_page
from drake_linefoot.lab.sweep.replays import write_replays
from drake_linefoot.lab.sweep.rows import FAILED, Made, Row, key_of, row_of
from drake_linefoot.lab.sweep.statistics import summarize_groups, worst
from drake_linefoot.lab.sweep.table import PARQUET, write_table
from drake_linefoot.lab.sweep.worker import carry_out
from drake_linefoot.lab.wiring.closed_loop import warm_up

SUMMARY, REPORT = "summary.json", "report.html"
OUT = Path("out/sweep")  # the results of a sweep go into its folder of its name
RECYCLE = 40  # runs of a local worker, see docs/sweeps.md
SAVE = 50  # runs between two tables
REPLAYS = 3  # of each group
SILENT = {"0", NOTHING}  # cells; a column that has no others is not printed
Outcome = Done[Job, Made]
TENTHS = 10  # of a sweep; at each one a line is printed where no bar can be shown


@dataclass(frozen=True)
class Options:
    """How a sweep is carried out.

    Attributes:
        out: folder of the results; None for the sweep's own in `OUT`.
        workers: worker processes; None for one per processor.
        scheduler: address of an existing cluster; None for processes on this machine.
        fresh: begin anew.
        replays: of the worst runs of each group.
        runs: of each group at most; None for as many as in the file.
        retry: carry out runs without an outcome again.
        simulator: of every run; None for that of the file.
    """

    out: Path | None = None
    workers: int | None = None
    scheduler: str | None = None
    fresh: bool = False
    replays: int = REPLAYS
    runs: int | None = None
    retry: bool = False
    simulator: str | None = None


def main_sweep(file: Path, options: Options, console: Console) -> tuple[Path, bool]:
    """Carry out a sweep, or go on with it; write table, summary, report and replays.

    Returns:
        The report, and whether every run has an outcome.

    Raises:
        InputError: the sweep or the scheduler is not usable, or the folder is of another sweep.
        OutputError: results cannot be written, or the folder holds other files.
        LinefootError: the cluster is lost; what was done is kept.
        KeyboardInterrupt: on Ctrl-C; what was done is kept, and it is said how to go on.
    """
    sweep = load_sweep(file, options.simulator)
    if options.runs is not None:
        sweep = sweep.at_most(options.runs)
    out = options.out or OUT / sweep.name
    _check_folder(out)
    with open_journal(out, header_of(sweep), options.fresh) as journal:
        results = Results(sweep, journal, out, file)
        try:
            carry_out_missing(results, options, console)
        except BaseException:
            results.write({}, REPLAYS)
            done = len(results.rows())
            console.print(f"{done} runs are kept in {out}; the same command goes on", markup=False)
            raise
        with console.status("replays of the worst runs"):
            replays = write_replays(sweep, results.worst(options.replays), out, console.print)
        results.write(replays, options.replays or REPLAYS)
        complete = not any(row["error"] for row in results.rows())
        rates = [RATES, *(rate_row(*item) for item in results.summary()["groups"].items())]
    columns = [column for column in zip(*rates, strict=True) if {*column[1:]} - SILENT]
    head, *rows = zip(*columns, strict=True)
    console.print(number_table(head, rows, wrapped=RATES[0]))
    return out / REPORT, complete


def _check_folder(out: Path) -> None:
    """Make the folder of the results; one that holds anything must be that of a sweep."""
    with writing(out):
        out.mkdir(parents=True, exist_ok=True)
        others = sorted(entry.name for entry in out.iterdir() if not entry.name.startswith("."))
        if others and not {JOURNAL, OLDER} & {*others}:
            shown = ", ".join(others[:3]) + ", ..." * (len(others) > 3)
            raise OutputError(out, f"holds other files ({shown}); name an empty or a new folder")


class Results:
    """The results of a sweep so far, and its files.

    Attributes:
        sweep: that is carried out.
        journal: of what is done.
    """

    def __init__(self, sweep: Sweep, journal: Journal, out: Path, file: Path) -> None:
        """Write into the folder `out`; `file` is the sweep's."""
        self.sweep, self.journal = sweep, journal
        self._out, self._file = out, file
        self._units = {path: unit_of(Scenario, parts_of(path)) for path in sampled_paths(sweep)}

    def by_group(self) -> dict[str, list[Row]]:
        """Return the rows of each group in order; a journal may have more than the sweep wants."""
        runs = self.sweep.runs
        groups: dict[str, list[Row]] = {name: [] for name in runs}
        for row in self.journal.rows():
            if 0 <= row["index"] < runs.get(row["group"], 0):
                groups[row["group"]].append(row)
        return groups

    def rows(self) -> list[Row]:
        """Return the rows of the sweep, group by group."""
        return [row for rows in self.by_group().values() for row in rows]

    def summary(self) -> dict[str, Any]:
        """Return what `summary.json` holds."""
        return {
            "sweep": self.sweep.name,
            "runs": self.sweep.runs,
            "seed": self.sweep.seed,
            "fingerprint": fingerprint(self.sweep),
            "made_with": made_with(),
            "groups": summarize_groups(self.by_group()),
        }

    def write_table(self) -> None:
        """Write the table."""
        about = {**header_of(self.sweep), "seed": self.sweep.seed}
        write_table(self._out / PARQUET, self.rows(), self._units, about)

    def worst(self, n: int) -> list[Row]:
        """Return the `n` worst runs of each group."""
        return [row for rows in self.by_group().values() for row in worst(rows, n)]

    def write(self, replays: Mapping[Key, str], worst_shown: int) -> None:
        """Write table, summary and report, which lists the worst runs with their `replays`."""
        summary = self.summary()
        self.write_table()
        text = json.dumps(summary, indent=2, allow_nan=False) + "\n"
        write_file(self._out / SUMMARY, text.encode())
        listed = [(row, replays.get(key_of(row), "")) for row in self.worst(worst_shown)]
        page = sweep_page(self.sweep, self.by_group(), summary, self._units, listed, self._file)
        write_file(self._out / REPORT, page.encode())


def carry_out_missing(results: Results, options: Options, console: Console) -> None:
    """Carry out the runs that have no row yet."""
    before = [row for row in results.rows() if not (options.retry and row["error"])]
    done = set(map(key_of, before))
    missing = [job for job in jobs(results.sweep) if job.key not in done]
    if missing and options.scheduler is None:
        warm_up()  # here, not in every worker
    with Board(results.sweep, console) as board:
        for row in before:
            board.count(row, before=True)
        if before:
            board.report(f"{len(before)} runs were done before")
        for n, one in enumerate(_carried_out(missing, options, board) if missing else (), 1):
            row = _row_of(one)
            results.journal.add(row)
            board.count(row)
            if n % SAVE == 0:
                results.write_table()


def _carried_out(missing: Sequence[Job], options: Options, board: "Board") -> Iterator[Outcome]:
    """Carry out runs on this machine, or on a cluster."""
    if options.scheduler is not None:
        with existing_cluster(options.scheduler) as client:
            yield from run_on_cluster(client, missing)
        return

    def report(job: Job, what: str) -> None:
        board.report(f"run {job.index} of {job.group} is done again: {what}")

    with Pool(options.workers, RECYCLE, most=len(missing)) as pool:
        yield from pool.run(carry_out, missing, attrgetter("limit"), report)


def _row_of(done: Outcome) -> Row:
    """Return the row of a run, also of one that has no outcome.

    Raises:
        LinefootError: its worker has other code.
    """
    if done.value is None:
        return row_of(done.job, FAILED, {"error": done.error, "attempts": done.attempts})
    row, theirs = done.value
    if changed := differences(made_with(), theirs):
        raise LinefootError(f"worker {row['worker']} has {changed}")
    return {**row, "attempts": done.attempts}


class Board(Progress):
    """Shows how far a sweep is, inside a `with` block."""

    def __init__(self, sweep: Sweep, console: Console) -> None:
        """Show the groups of `sweep` on `console`."""
        super().__init__(
            TextColumn("{task.fields[group]}"),
            BarColumn(bar_width=20),
            MofNCompleteColumn(),
            TextColumn("{task.description}"),
            TimeRemainingColumn(),
            console=console,
            transient=True,
            disable=not console.is_terminal,
        )
        runs = sweep.runs
        self._total = sum(runs.values())
        self._good, self._done = dict.fromkeys(runs, 0), dict.fromkeys(runs, 0)
        self._bars = {
            name: self.add_task("", total=total, group=escape(name)) for name, total in runs.items()
        }

    def count(self, row: Row, before: bool = False) -> None:
        """Count a run; `before` for one that was done when the sweep began."""
        group = row["group"]
        self._done[group] += 1
        self._good[group] += upright(row)
        rate = self.rate(group)
        self.update(self._bars[group], completed=self._done[group], description=rate)
        done = sum(self._done.values())
        tenth = done * TENTHS // self._total > (done - 1) * TENTHS // self._total
        if tenth and not before and not self.console.is_terminal:
            rates = ", ".join(f"{name} {self.rate(name)}" for name in self._good)
            self.report(f"{done} of {self._total} runs: {rates}")

    def rate(self, group: str) -> str:
        """Return the success rate of a group so far, in words."""
        if not self._done[group]:
            return "-"
        return f"{100.0 * self._good[group] / self._done[group]:.1f} % upright"

    def report(self, text: str) -> None:
        """Print a line above the bars."""
        self.console.print(legible(text, 1000), markup=False)
