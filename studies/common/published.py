"""What a sweep of robustness has published is not simulated again, on whatever machine that was."""

from pathlib import Path

from drake_linefoot.files import writing
from drake_linefoot.lab.sweep.file import Sweep
from drake_linefoot.lab.sweep.jobs import Key, header_of
from drake_linefoot.lab.sweep.journal import open_journal
from drake_linefoot.lab.sweep.rows import Row, key_of
from drake_linefoot.lab.sweep.table import PARQUET, read_table
from studies.common.command import DOCS


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
