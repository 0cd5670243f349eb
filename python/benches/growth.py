"""How the cost of sweeps and of folders of bags grows with their size, on a Dask cluster of worker processes on this machine.

    python python/benches/growth.py [--workers 2] [--dives 100 1000 10000] [--short 1000 10000 100000] [--bags 10 100 1000]

Prints a line for each size: wall time, CPU of scheduler, client and workers together, CPU of one case, size of the dataset, and the largest
worker. Dives are of 90 s with a Kalman filter; short ones of 1 s show what a case costs beside its flight. Bags are links to one dive of 90 s.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import psutil
import pyarrow.dataset
from distributed import Client, LocalCluster

import planesman


def cpu() -> float:
    """CPU of this process and its children, s."""
    family = [psutil.Process(), *psutil.Process().children(recursive=True)]
    return sum(sum(one.cpu_times()[:2]) for one in family)


def measure(what: str, size: int, work: Callable[[Path], Path], client: Client) -> None:
    with tempfile.TemporaryDirectory() as folder:
        before, start = cpu(), time.perf_counter()
        dataset = work(Path(folder))
        wall, used = time.perf_counter() - start, cpu() - before
        files = list(dataset.iterdir())
        rows = pyarrow.dataset.dataset(dataset).count_rows()
        assert rows == size, (rows, size)
        mebibytes = sum(file.stat().st_size for file in files) / 2**20
        resident = max(client.run(lambda: psutil.Process().memory_info().rss).values()) / 2**20
    print(
        f"{what:<8} {size:>7} {len(files):>5} files {wall:>8.2f} s wall {used:>8.2f} s CPU {used / size * 1e3:>8.3f} ms each "
        f"{mebibytes:>8.2f} MiB, worker {resident:.0f} MiB",
        flush=True,
    )


def sweep(duration: float, size: int, client: Client) -> Callable[[Path], Path]:
    return lambda folder: planesman.sweep(
        {"description": "growth", "duration": duration, "parameters": {"depth_controller": {"depth_setpoint": 0.9}}},
        {"depth_controller.depth.p": "0.4..1.6"},
        samples=size,
        out=folder,
        client=client,
        depth_controller={"feedback.source": "kalman"},
    )


def fits(size: int, client: Client) -> Callable[[Path], Path]:
    def work(folder: Path) -> Path:
        bag = folder / "dive.mcap"
        planesman.simulate("dive", bag=bag, depth_controller={"feedback.source": "kalman"})
        (folder / "bags").mkdir()
        for number in range(size):
            os.link(bag, folder / "bags" / f"{number:06}.mcap")
        return planesman.fit_all(
            folder / "bags",
            "plane_motion:dive_planes",
            "imu:angular_velocity.y",
            window=(20, 90),
            order=3,
            delay=1,
            out=folder / "fits",
            client=client,
        )

    return work


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--dives", type=int, nargs="*", default=[100, 1000, 10_000])
    parser.add_argument("--short", type=int, nargs="*", default=[1000, 10_000, 100_000])
    parser.add_argument("--bags", type=int, nargs="*", default=[10, 100, 1000])
    args = parser.parse_args()
    cluster = LocalCluster(n_workers=args.workers, threads_per_worker=1, host="127.0.0.1", dashboard_address=None)
    with cluster, Client(cluster) as client:
        for size in args.dives:
            measure("dives", size, sweep(90.0, size, client), client)
        for size in args.short:
            measure("short", size, sweep(1.0, size, client), client)
        for size in args.bags:
            measure("bags", size, fits(size, client), client)


if __name__ == "__main__":
    main()
