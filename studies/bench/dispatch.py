"""How many runs a second a sweep can hand out: workers on loopback whose runs take no time.

Scheduler and workers are threads of this process, so what is measured is less than what a cluster
of machines can do. The journal is written, to the disk, as in a sweep.
"""

import pickle
import tempfile
from collections.abc import Sequence
from pathlib import Path
from time import perf_counter
from unittest.mock import patch

from distributed import Client, LocalCluster

from drake_linefoot.lab.pool import Done
from drake_linefoot.lab.results.provenance import made_with
from drake_linefoot.lab.sweep import cluster
from drake_linefoot.lab.sweep.file import load_sweep
from drake_linefoot.lab.sweep.jobs import Job, job
from drake_linefoot.lab.sweep.journal import JOURNAL, open_journal
from drake_linefoot.lab.sweep.rows import Made, Row
from drake_linefoot.lab.sweep.worker import carry_out
from studies.common.types import Data

SWEEP = Path("examples/sweeps/nominal.yaml")
WORKERS = (1, 4, 16, 64)
RUNS = 400
MANY = 100_000  # runs, of which it is said what they take


def dispatch_over_workers(
    file: Path = SWEEP, workers: Sequence[int] = WORKERS, runs: int = RUNS
) -> Data:
    """Hand out runs that take no time to more and more workers.

    Args:
        file: of the sweep whose runs these are.
        workers: numbers of them.
        runs: handed out to each number of workers.

    Returns:
        `sweep`: its name; `run_s`: what a run takes on this machine; `job_bytes` to its worker,
        `row_bytes` back, `journal_bytes` on the disk; and for each of `workers`
        `handed_out_per_s`, `finished_per_s` if runs took their time, `hours_for_many`.
    """
    sweep = load_sweep(file)
    first = job(sweep, sweep.groups[0], 0)
    row, _ = [carry_out(first) for _ in range(2)][-1]  # the first has machine code to load
    rates, journal = [], 0
    for count in workers:
        jobs = [job(sweep, sweep.groups[0], i) for i in range(runs)]
        seconds, journal = _handed_out(jobs, row, count)
        rates.append(runs / seconds)
    own = [count / row["wall_seconds"] for count in workers]
    return {
        "sweep": sweep.name,
        "run_s": row["wall_seconds"],
        "job_bytes": len(pickle.dumps(first)),
        "row_bytes": len(pickle.dumps((row, made_with()))),
        "journal_bytes": round(journal / runs),
        "workers": list(workers),
        "handed_out_per_s": rates,
        "finished_per_s": own,
        "many": MANY,
        "hours_for_many": [MANY / min(pair) / 3600.0 for pair in zip(rates, own, strict=True)],
    }


def _handed_out(jobs: list[Job], row: Row, count: int) -> tuple[float, int]:
    """Return the time [s], and the size of the journal."""

    def at_once(job: Job) -> Done[Job, Made]:
        own = {**row, "group": job.group, "index": job.index, "seed": job.seed}
        return Done(job, (own, made_with()))

    header = {"name": "", "fingerprint": "", "made_with": {}}
    with (
        tempfile.TemporaryDirectory() as folder,
        LocalCluster(
            n_workers=count,
            threads_per_worker=1,
            processes=False,
            host="127.0.0.1",
            protocol="tcp",
            dashboard_address=None,
            memory_limit=0,  # each would watch that of the whole process
            silence_logs=50,
        ) as made,
        Client(made, set_as_default=False) as client,
        patch.object(cluster, "carry_out_apart", at_once),
        open_journal(Path(folder), header, fresh=True) as journal,
    ):
        start = perf_counter()
        for done in cluster.run_on_cluster(client, jobs):
            assert done.value is not None
            journal.add(done.value[0])
        seconds = perf_counter() - start
        assert len(journal.rows()) == len(jobs)
        return seconds, (Path(folder) / JOURNAL).stat().st_size
