"""What a sweep of robustness has published is not simulated again, on whatever machine that was."""

from pathlib import Path

import numpy as np

from drake_linefoot.files import writing
from drake_linefoot.lab.pool import Pool
from drake_linefoot.lab.results.judge import OUTCOME
from drake_linefoot.lab.sweep.file import Sweep
from drake_linefoot.lab.sweep.jobs import Key, header_of, job
from drake_linefoot.lab.sweep.journal import open_journal
from drake_linefoot.lab.sweep.rows import RUN, Row, key_of
from drake_linefoot.lab.sweep.table import PARQUET, read_table, write_table
from drake_linefoot.lab.sweep.worker import carry_out
from studies.common.command import DOCS
from studies.common.trials import SAMPLE

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
    if any(about.get(name) != header[name] for name in OF_SWEEP) or header.items() <= about.items():
        return 0
    groups = {group.name: group for group in sweep.groups}
    there = {key_of(row): row for row in rows}
    few = np.random.default_rng(len(rows)).permutation(len(rows))[:SAMPLE]
    again = [job(sweep, groups[rows[i]["group"]], rows[i]["index"]) for i in few]
    with Pool(workers, most=len(again)) as pool:
        for one in pool.run(carry_out, again, lambda of: of.limit):
            row = one.value[0] if one.value else {}
            if any(row.get(name) != there[one.job.key][name] for name in (*RUN, *OUTCOME)):
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
