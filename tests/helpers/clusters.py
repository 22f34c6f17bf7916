"""Clusters of dask for tests."""

import subprocess
import sys
from contextlib import contextmanager

SCHEDULER = """
from distributed import LocalCluster
if __name__ == "__main__":
    cluster = LocalCluster(
        n_workers=1,
        threads_per_worker=1,
        processes=False,
        host="127.0.0.1",
        protocol="tcp",
        dashboard_address="127.0.0.1:0",
    )
    print(cluster.scheduler_address, flush=True)
    input()
"""


@contextmanager
def existing(folder):
    """A scheduler with a worker in a process of its own; gives the process and the address."""
    script = folder / "existing_cluster.py"
    script.write_text(SCHEDULER)
    command, pipe = [sys.executable, str(script)], subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True) as process:
        try:
            yield process, process.stdout.readline().strip()
        finally:
            process.kill()
