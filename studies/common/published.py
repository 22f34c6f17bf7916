"""What a sweep of robustness has published is not simulated again, on whatever machine that was."""

import json
from pathlib import Path

from drake_linefoot.errors import InputError
from drake_linefoot.files import writing
from drake_linefoot.lab.results.provenance import made_with
from drake_linefoot.lab.sweep.file import Sweep
from drake_linefoot.lab.sweep.jobs import Key, fingerprint
from drake_linefoot.lab.sweep.journal import open_journal
from drake_linefoot.lab.sweep.rows import Row, key_of
from drake_linefoot.lab.sweep.table import PARQUET, read_table
from studies.common.command import DOCS
from studies.common.types import Data

SUMMARY = "summary.json"
FINGERPRINTS = "fingerprints"  # entry of the summary: what decides what the runs of a sweep are


def table_of(sweep: str, out: Path) -> Path:
    """Return where the table of a sweep is published."""
    return out / Path(sweep).with_suffix(Path(PARQUET).suffix)


def published_rows(sweep: Sweep, out: Path = DOCS / "robustness") -> dict[Key, Row]:
    """Return the runs of a published sweep by key; none where other code or sweep made them.

    Args:
        sweep: whose runs are asked for.
        out: folder in which its table and the summary of the study are.

    Raises:
        InputError: the table or the summary cannot be read.
    """
    table, file = table_of(sweep.name, out), out / SUMMARY
    if not (table.exists() and file.exists()):
        return {}
    try:
        summary: Data = json.loads(file.read_text(encoding="utf-8"))
        mark = summary.get(FINGERPRINTS, {}).get(sweep.name)
    except (OSError, ValueError, AttributeError) as error:
        raise InputError(file, "", "summary", f"cannot be read: {error}") from error
    rows, _, about = read_table(table)
    if about["made_with"] != made_with() or mark != fingerprint(sweep):
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
    header = {"name": sweep.name, "fingerprint": fingerprint(sweep), "made_with": made_with()}
    with open_journal(folder, header, fresh=False) as journal:
        return sum(journal.add(row) for row in rows.values())
