"""A map on a real Dask scheduler with two worker processes on this machine."""

from __future__ import annotations

import json
import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from robimp.synthesis import InputError, map_plane
from robimp.synthesis.sweep.cell import Status

distributed = pytest.importorskip("distributed")

AXES = {"impedance.stiffness": "2:8:2", "impedance.damping": "0.2:0.6:2"}


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
    ) as running:
        yield running


def statuses(folder: Path) -> dict[tuple[int, int], str]:
    lines = [json.loads(line) for line in (folder / "map.journal").read_bytes().splitlines()[1:]]
    return {tuple(line["cell"]): line["status"] for line in lines}


def test_a_cluster_finds_what_processes_find(cluster: Any, small: Path, tmp_path: Path) -> None:
    there = map_plane(small, AXES, tmp_path / "there", dask=cluster.scheduler_address)
    here = map_plane(small, AXES, tmp_path / "here", processes=1)
    assert len(there.cells) == 4
    for index, cell in here.cells.items():
        other = there.cells[index]
        assert (other.status, other.omega_B, other.reason) == (cell.status, cell.omega_B, cell.reason)


def test_a_worker_of_the_cluster_that_is_killed_costs_nothing(cluster: Any, small: Path, tmp_path: Path) -> None:
    killed = []

    def kill_one(done: int, failed: int) -> None:
        if done and not killed:
            killed.append(next(iter(cluster.workers.values())).pid)
            os.kill(killed[0], signal.SIGKILL)

    found = map_plane(small, AXES, tmp_path / "map", dask=cluster.scheduler_address, progress=kill_one)
    assert killed and len(found.cells) == 4 and found.counts[Status.ERROR] == 0
    assert len(statuses(tmp_path / "map")) == 4


def test_a_dead_address_leaves_nothing_behind_and_harms_nothing(small: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no scheduler answers"):
        map_plane(small, AXES, tmp_path / "map", dask="tcp://127.0.0.1:9")
    assert not (tmp_path / "map").exists(), "no journal, no folder"
    map_plane(small, AXES, tmp_path / "map", processes=1)
    kept = (tmp_path / "map" / "map.journal").read_bytes()
    map_plane(small, AXES, tmp_path / "map", dask="tcp://127.0.0.1:9")  # all is done: no cluster is needed
    assert (tmp_path / "map" / "map.journal").read_bytes() == kept


def test_workers_with_threads_are_refused(small: Path, tmp_path: Path) -> None:
    with (
        distributed.LocalCluster(
            n_workers=1, threads_per_worker=2, processes=False, dashboard_address=None, silence_logs=50
        ) as threaded,
        pytest.raises(InputError, match="--nthreads 1"),
    ):
        map_plane(small, AXES, tmp_path / "map", dask=threaded.scheduler_address)


def test_a_cluster_without_workers_is_refused(small: Path, tmp_path: Path) -> None:
    with (
        distributed.LocalCluster(n_workers=0, processes=False, dashboard_address=None, silence_logs=50) as empty,
        pytest.raises(InputError, match="has no workers"),
    ):
        map_plane(small, AXES, tmp_path / "map", dask=empty.scheduler_address)
