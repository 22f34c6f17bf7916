"""Clusters of dask for tests."""

import subprocess
import sys
from contextlib import contextmanager

import dask

SCHEDULER = """
from distributed import LocalCluster
if __name__ == "__main__":
    cluster = LocalCluster(
        n_workers=1, threads_per_worker=1, host="127.0.0.1", dashboard_address="127.0.0.1:0"
    )
    print(cluster.scheduler_address, flush=True)
    input()
"""


@contextmanager
def trusted(client):
    """Have the keys of a local cluster in the settings of dask, as users of a cluster do."""
    security = client.security
    tls = {
        "distributed.comm.tls.ca-file": security.tls_ca_file,
        "distributed.comm.tls.client.key": security.tls_client_key,
        "distributed.comm.tls.client.cert": security.tls_client_cert,
    }
    with dask.config.set(tls):
        yield client.scheduler.address


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
