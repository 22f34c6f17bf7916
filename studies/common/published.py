"""What a sweep of robustness has published is not simulated again, on whatever machine that was."""

from pathlib import Path

from drake_linefoot.files import writing
from drake_linefoot.lab.results.judge import OUTCOME
from drake_linefoot.lab.sweep.file import Sweep
from drake_linefoot.lab.sweep.jobs import Job, Key, header_of, job
from drake_linefoot.lab.sweep.journal import open_journal
from drake_linefoot.lab.sweep.rows import RUN, Made, Row, key_of
from drake_linefoot.lab.sweep.table import PARQUET, read_table, write_table
from drake_linefoot.lab.sweep.worker import carry_out
from studies.common.command import DOCS
from studies.common.trials import hold, sampled

OF_SWEEP = ("name", "fingerprint")  # of a table: what does not depend on the code


def table_of(sweep: str, out: Path) -> Path:
    """Return where the table of a sweep is published."""
    return out / Path(sweep).with_suffix(Path(PARQUET).suffix)


def published_rows(sweep: Sweep, out: Path = DOCS / "robustness") -> dict[Key, Row]:
    """Return the runs of a published sweep by key; none where other code or sweep made them.

    Args:
        sweep: whose runs are asked for.
        out: folder in which its table is.

    Raises:
        InputError: the table cannot be read.
    """
    table = table_of(sweep.name, out)
    if not table.exists():
        return {}
    rows, _, about = read_table(table)
    if not header_of(sweep).items() <= about.items():
        return {}
    return {key_of(row): row for row in rows}


def hold_over(sweep: Sweep, out: Path, workers: int | None) -> int:
    """Keep the runs of a published sweep that other code made, if this one finds the same.

    A random sample is carried out again; when the outcome of each is the same to the last bit, the
    table says that the code of today made it.

    Args:
        sweep: whose runs they are.
        out: folder in which its table is.
        workers: processes; None: one per processor.

    Returns:
        How many there are; 0 where this code made them already, or does not find the same.

    Raises:
        InputError: the table cannot be read.
        OutputError: it cannot be written.
    """
    table, header = table_of(sweep.name, out), header_of(sweep)
    if not table.exists():
        return 0
    rows, units, about = read_table(table)
    is_other = any(about.get(name) != header[name] for name in OF_SWEEP)
    if not rows or is_other or header.items() <= about.items():
        return 0
    groups = {group.name: group for group in sweep.groups}
    there = {key_of(row): row for row in rows}
    again = [job(sweep, groups[row["group"]], row["index"]) for row in sampled(rows)]

    def is_same(of: Job, made: Made | None) -> bool:
        return made is not None and all(
            made[0][name] == there[of.key][name] for name in (*RUN, *OUTCOME)
        )

    if not hold(again, carry_out, is_same, lambda of: of.limit, workers):
        return 0
    write_table(table, rows, units, {**about, **header})
    return len(rows)


def go_on_from(sweep: Sweep, out: Path, folder: Path) -> int:
    """Put the runs that are published into the journal of a sweep; return how many were new.

    Args:
        sweep: that is to be carried out.
        out: see `published_rows`.
        folder: of the journal; made.

    Raises:
        InputError: as `published_rows`; or the journal is of something else.
        OutputError: the journal cannot be written.
    """
    if not (rows := published_rows(sweep, out)):
        return 0
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
    with open_journal(folder, header_of(sweep), fresh=False) as journal:
        return sum(journal.add(row) for row in rows.values())
