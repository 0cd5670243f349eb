"""Plots of cost against size."""

from pathlib import Path
from statistics import median

import matplotlib

matplotlib.use("svg")
matplotlib.rcParams["svg.hashsalt"] = "planesman"
from matplotlib import pyplot  # noqa: E402

from table import of_case  # noqa: E402


def write(document: dict, cases: dict, folder: Path) -> None:
    """A file for each case with sizes, a plot for each measure in it; whiskers reach from the least to the largest round."""
    folder.mkdir(exist_ok=True)
    for name, case in cases.items():
        if not hasattr(case, "POINTS"):
            continue
        rows = of_case(document, name)
        measures = list(dict.fromkeys(measure for row in rows for measure in row["costs"]))
        if not measures:
            continue
        columns = min(3, len(measures))
        lines = -(-len(measures) // columns)
        figure, plots = pyplot.subplots(lines, columns, figsize=(4.2 * columns, 3.4 * lines), squeeze=False, layout="constrained")
        for unused in plots.flat[len(measures) :]:
            unused.set_axis_off()
        for axes, measure in zip(plots.flat, measures):
            for contender in dict.fromkeys(row["contender"] for row in rows):
                found = [(row["point"], row["costs"][measure]) for row in rows if row["contender"] == contender and measure in row["costs"]]
                if found:
                    x, costs = zip(*found)
                    middle = [median(values) for values in costs]
                    below = [m - min(values) for m, values in zip(middle, costs)]
                    above = [max(values) - m for m, values in zip(middle, costs)]
                    axes.errorbar(x, middle, yerr=[below, above], marker="o", capsize=3, label=contender)
            if max(case.POINTS) >= 30 * min(case.POINTS):
                axes.set_xscale("log")
                axes.set_yscale("log")
            else:
                axes.set_ylim(bottom=0)
                axes.set_xticks(case.POINTS)
            axes.set_xlabel(case.X)
            axes.set_ylabel(measure)
            axes.grid(alpha=0.3)
            axes.legend(fontsize="small")
        figure.suptitle(case.TITLE)
        figure.savefig(folder / f"{name}.svg", metadata={"Date": None})
        pyplot.close(figure)
