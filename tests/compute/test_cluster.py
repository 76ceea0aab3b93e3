"""A worker that runs another lgmd2jax than its client is refused, before it computes anything."""

import os
import shutil
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest
from distributed import Client, LocalCluster

import lgmd2jax
from lgmd2jax._compute.cluster import checked_client, prepare_worker, running_versions


@pytest.fixture(scope="module")
def client():
    """A scheduler without workers of its own."""
    settings = {"n_workers": 0, "processes": False, "protocol": "tcp", "host": "127.0.0.1", "dashboard_address": ":0"}
    with LocalCluster(**settings) as cluster, Client(cluster) as client:
        yield client


@pytest.mark.parametrize("package", ["jax", "jaxlib", "equinox", "optimistix", "lineax", "numpy"])
def test_a_worker_tells_what_decides_its_numbers(package):
    assert f"{package} {version(package)}" in running_versions()


def test_a_worker_with_another_source_is_refused_by_both_names(client, tmp_path):
    package = shutil.copytree(Path(lgmd2jax.__file__).parent, tmp_path / "lgmd2jax")
    with open(package / "_words.py", "a") as file:
        file.write("# another version\n")
    assert checked_client(client) is client
    address = client.scheduler_info()["address"]
    command = [sys.executable, "-m", "distributed.cli.dask_worker", address, "--no-dashboard", "--no-nanny"]
    environment = os.environ | {"PYTHONPATH": str(tmp_path)}
    with subprocess.Popen(command, cwd=tmp_path, env=environment, stderr=subprocess.DEVNULL) as worker:
        try:
            client.wait_for_workers(1, timeout=60)
            with pytest.raises(ValueError, match="install the same version for both") as refused:
                checked_client(client)
            assert f"this process {running_versions()}" in str(refused.value)
            assert str(refused.value).count("lgmd2jax") == 2
            late = client.submit(prepare_worker, running_versions())
            with pytest.raises(ValueError, match="install the same version"):
                late.result()
        finally:
            worker.terminate()
