"""Measures the cases: `run` starts this in a network namespace, by the Python that has the peers.

A case is a file of cases/ with

- TITLE: what is measured, for the heading of its table or its rows.
- contenders(): functions by name, ours first. Each measures one round and returns its costs by measure with unit: {"dive [ms]": 5.8}.
- where the cost is measured at several sizes: POINTS, the sizes; QUICK, those of `run --quick`; X, what they are. The functions then take a size.
- PEERS = False, where the contenders are not to be compared; ROUNDS, where fewer than usual are enough; NOTE, a sentence below the table.
"""

import importlib
import json
import signal
import sys
import traceback
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import table
import tools

PATIENCE = 180
"""Longest that a contender may take for one round [s]."""


def measure(name: str, case, rounds: int, quick: bool) -> list[dict]:
    """A row for each size and contender: the costs of all rounds, or why there are none. In each round the contenders take turns."""
    rounds = min(rounds, getattr(case, "ROUNDS", rounds))
    points = getattr(case, "POINTS", [None])
    if quick:
        points = getattr(case, "QUICK", points[:1])
    try:
        contenders = case.contenders()
    except Exception as error:
        return [{"case": name, "point": None, "contender": "planesman", "costs": {}, "failed": told(error)}]
    rows = []
    for point in points:
        label = name if point is None else f"{name} {point}"
        found = [{"case": name, "point": point, "contender": contender, "costs": {}, "failed": None} for contender in contenders]
        for turn in range(rounds):
            for row, work in zip(found, contenders.values()):
                if row["failed"]:
                    continue
                try:
                    costs = limited(work if point is None else lambda: work(point))
                except Exception as error:
                    row["failed"] = told(error)
                    tools.say(f"{label} {row['contender']}: failed: {row['failed']}")
                    continue
                for measure, cost in costs.items():
                    row["costs"].setdefault(measure, []).append(cost)
                shown = ", ".join(f"{measure} {cost:.4g}" for measure, cost in costs.items())
                tools.say(f"{label} round {turn + 1} {row['contender']}: {shown}")
        rows += found
    return rows


def limited(work):
    """The result of `work`, which is broken off when it takes too long."""

    def stop(*_):
        raise TimeoutError(f"took longer than {PATIENCE} s")

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(PATIENCE)
    try:
        return work()
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def told(error: Exception) -> str:
    """An error in one line."""
    if not isinstance(error, (tools.Missing, TimeoutError)):
        traceback.print_exception(error)
    return f"{type(error).__name__}: {error}".removeprefix("Missing: ").replace("\n", " ")[:200]


def main() -> None:
    options = tools.set_options(sys.argv[1])
    import machine
    import plots

    document = {"machine": machine.machine(), "versions": machine.versions(), "rounds": options["rounds"], "rows": []}
    cases, text = {}, ""
    for name in options["cases"]:
        try:
            cases[name] = importlib.import_module(f"cases.{name}")
        except ImportError as error:
            cases[name] = SimpleNamespace(TITLE=name.capitalize(), contenders=partial(refuse, error))
        document["rows"] += measure(name, cases[name], options["rounds"], options["quick"])
        text = table.markdown(document, cases)
        if options["complete"]:
            (tools.HERE / "results.md").write_text(text)
            (tools.HERE / "results.json").write_text(json.dumps(document, indent=1) + "\n")
    if options["complete"]:
        plots.write(document, cases, tools.HERE / "plots")
    if options["sets"]:
        import public_sets

        text += "\n" + public_sets.table(Path(options["sets"]))
        if options["complete"]:
            (tools.HERE / "results.md").write_text(text)
    print(text)


def refuse(error: Exception):
    raise error


if __name__ == "__main__":
    main()
