"""Many vehicles, each with five nodes and a launcher: in one domain and in one each, in real time and in lockstep."""

import itertools
import os
import re
import subprocess
import tempfile
import threading
import time
from pathlib import Path

import psutil

from tools import Missing, OPTIONS, cpu, memory, program

TITLE = "Many vehicles"
X = "vehicles"
POINTS = [1, 2, 5, 10]
QUICK = [1, 2]
ROUNDS = 1
PEERS = False
NOTE = (
    "each vehicle is five nodes, one of them a recorder, and a launcher with its progress; all on one machine, started at once, in one domain where nothing else is said. "
    "Full rate is 20 ticks a second. The time to the release of the last vehicle has the start of the processes, half a second of listening for other loops and the discovery "
    "of every endpoint in it. CPU and memory (shares of what is shared included) are of all processes while all fly."
)
TICK = 0.05
DOMAINS = itertools.count(51)


def contenders():
    real, lockstep = ["--factor", "1"], ["--lockstep"]
    return {
        "real time": lambda vehicles: fly(real, [next(DOMAINS)] * vehicles),
        "real time, a domain each": lambda vehicles: fly(real, [next(DOMAINS) for _ in range(vehicles)]),
        "lockstep": lambda vehicles: fly(lockstep, [next(DOMAINS)] * vehicles),
    }


def fly(pace: list[str], domains: list[int]) -> dict[str, float]:
    """A vehicle for each domain of the list."""
    real = pace[0] == "--factor"
    duration = 10 if OPTIONS["quick"] else 15 if real else 30
    with tempfile.TemporaryDirectory() as folder:
        scenario = Path(folder) / "short.yaml"
        scenario.write_text(f"description: one of many\nduration: {duration}\nparameters:\n  sysid: {{start: 2.0}}\n")
        begin = time.time()
        dives = [Dive(scenario, pace, f"/auv{vehicle}", Path(folder) / str(vehicle), domain) for vehicle, domain in enumerate(domains)]
        samples, done = [], threading.Event()
        watch = threading.Thread(target=account, args=(dives, samples, done))
        watch.start()
        try:
            for dive in dives:
                dive.finish()
        finally:
            done.set()
            watch.join()
            for dive in dives:
                dive.process.kill()  # Its nodes end with it.
        found = {"to the last release [s]": max(dive.released for dive in dives) - begin}
        if not real:
            ticks = sum(round(dive.flown / TICK) for dive in dives)
            over = max(dive.released + dive.took for dive in dives) - min(dive.released for dive in dives)
            return {**found, "all together [ticks/s]": ticks / over}
        flights = [states(dive) for dive in dives]
    rates = [(len(flight) - 1) / (flight[-1] - flight[0]) for flight in flights]
    gaps = [b - a for flight in flights for a, b in zip(flight, flight[1:])]
    found |= {"slowest [ticks/s]": min(rates), "longest gap [ms]": 1e3 * max(gaps)}
    first, last = max(flight[0] for flight in flights), min(flight[-1] for flight in flights)
    during = [sample for sample in samples if first <= sample[0] <= last]
    if len(during) > 1:
        found["CPU [cores]"] = (during[-1][1] - during[0][1]) / (during[-1][0] - during[0][0])
        found["memory [MB]"] = during[-1][2]
    return found


class Dive:
    """A launcher, and what it has printed so far."""

    def __init__(self, scenario: Path, pace: list[str], namespace: str, out: Path, domain: int):
        command = [program("planesman"), "dive", str(scenario), *pace, "--verbose", "--namespace", namespace, "--out", str(out)]
        self.namespace, self.out = namespace, out
        self.released, self.flown, self.took, self.last = None, None, None, ""
        where = {**os.environ, "ROS_DOMAIN_ID": str(domain)}
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=where)
        self._reader = threading.Thread(target=self._read)
        self._reader.start()

    def _read(self) -> None:
        for line in self.process.stdout:
            if "discovered each other" in line:
                self.released = time.time()
            if flew := re.match(r"Flew ([\d.]+) s of vehicle time in ([\d.]+) s", line):
                self.flown, self.took = float(flew[1]), float(flew[2])
            self.last = line.strip() or self.last

    def finish(self) -> None:
        status = self.process.wait()
        self._reader.join()
        if status != 0 or self.took is None or self.released is None:
            raise Missing(f"{self.namespace} ended with {status}: {self.last}")


def account(dives: list, samples: list, done: threading.Event) -> None:
    """Time, CPU time and memory of all processes, every second."""
    while not done.wait(1.0):
        processes = []
        for dive in dives:
            try:
                pid = dive.process.pid
                processes += [pid, *(child.pid for child in psutil.Process(pid).children(recursive=True))]
            except psutil.NoSuchProcess:
                pass  # It has ended.
        samples.append((time.time(), sum(map(cpu, processes)), sum(map(memory, processes))))


def states(dive: Dive) -> list[float]:
    """When the recorder received each state [s]; in lockstep that would be the vehicle's own time."""
    from mcap.reader import make_reader

    topic, found = f"{dive.namespace}/state", []
    for path in sorted((dive.out / "bag").glob("*.mcap")):
        with path.open("rb") as file:
            found += [message.log_time * 1e-9 for _, _, message in make_reader(file).iter_messages(topics=[topic])]
    if len(found) < 2:
        raise Missing(f"{topic} has {len(found)} messages")
    return found
