"""The judged records as a page: the verdict as a classifier, by situation, and what it says of causes."""

from collections import Counter

from judge import IN_BAND, LEAST_SAMPLES, NEAR, SIGMAS, SOLVED

GROUPS = ["plant", "input", "noise", "log", "samples"]
TARGETS = {"precision": 98.0, "recall": 97.0, "causes": 95.0}


def grouped(rows, names):
    """Rows by the values of these columns, in the order in which they come."""
    groups = {}
    for row in rows:
        groups.setdefault(tuple(row[name] for name in names), []).append(row)
    return groups


def several(text):
    """The names in a cell."""
    return [it for it in (text or "").split(", ") if it]


def counts(rows):
    """Right ones and all: of records called good those that are, of records that should be called so those that are, of causes named those that are there."""
    good, should = [it for it in rows if it["good"]], [it for it in rows if it["should"]]
    causes, false = (sum(len(several(it.get(name))) for it in rows) for name in ("named", "false"))
    return {
        "precision": (sum(not it["wrong"] for it in good), len(good)),
        "recall": (sum(it["good"] for it in should), len(should)),
        "causes": (causes - false, causes),
    }


def held(rows, name):
    """How many of the printed intervals hold the truth, of how many, among records called good."""
    known = [it[f"{name}_held"] for it in rows if it["good"] and it.get(f"{name}_held") is not None]
    return sum(known), len(known)


def share(of):
    """A share in %, with its count."""
    right, total = of
    return f"{100 * right / total:.1f} ({right}/{total})" if total else ""


def line(cells):
    return "| " + " | ".join(map(str, cells)) + " |"


def heading(*names):
    return [line(names), "|---" * len(names) + "|"]


def markdown(rows, about):
    """The page."""
    seeds = sorted({it["seed"] for it in rows})
    situations = grouped(rows, GROUPS)
    total = counts(rows)
    lines = ["# What the verdict of `planesman sysid fit` is worth", ""]
    lines += [f"Made by `{about['command']}` at commit {about['commit']}, {about['date']}: {len(situations)} situations, seeds {', '.join(map(str, seeds))},"]
    lines += [f"{len(rows)} records of known truth, {sum(it['seconds'] for it in rows) / 60:.0f} minutes of fits. All records are in results.csv.", ""]
    lines += ["- *precision*: of the records called good, those that are right: over three time constants the step response is within"]
    lines += [f"  {100 * NEAR:.0f} % (2-norm) of the true one, or its 95 % band holds {100 * IN_BAND:.0f} % of the points; and the delay's interval holds"]
    lines += ["  the true delay.", "- *recall*: of records without noise, or with 5 % white noise and a rich input, that least squares of the true"]
    lines += [f"  structure solves within {100 * SOLVED:.0f} %, those called good.", "- *causes*: of causes named (closed loop, backlash, dead zone, saturation, square law,"]
    lines += ["  friction, drag, changing gain, drift, disturbance, quantised, clock), those that are in the record.", ""]
    lines += ["A sensor that clips is part of the plant, with its limits. Where the logger moves the times (held, jitter, digits lost) the delay may"]
    lines += ["be off by one or two samples. A fit that is refused with the gain of a static plant named counts as a model called good. Of records with"]
    lines += [f"noise those of fewer than {LEAST_SAMPLES} samples do not count for recall.", ""]
    lines += heading("", "measured, %", "target, %")
    lines += [line([name, share(total[name]), target]) for name, target in TARGETS.items()]
    lines += ["", f"Printed 95 % intervals (±{SIGMAS} standard deviations) that hold the truth, of records called good: "]
    lines[-1] += ", ".join(f"{name} {share(held(rows, name))}" for name in ("gain", "poles", "delay")) + "."
    lines += ["", "## By class", "", *heading("class", "records", *TARGETS)]
    for name in GROUPS:
        lines += [line([f"{name}: {value}", len(group), *map(share, counts(group).values())]) for (value,), group in grouped(rows, [name]).items()]
    lines += ["", "## Causes named", "", *heading("cause", "right", "wrong", "wrong in (records)")]
    named, false = (Counter(cause for it in rows for cause in several(it.get(column))) for column in ("named", "false"))
    for cause, count in named.most_common():
        where = Counter(f"{it['plant']}, {it['input']}, {it['noise']}, {it['log']}" for it in rows if cause in several(it.get("false")))
        lines.append(line([cause, count - false[cause], false[cause], "; ".join(f"{place} ({n})" for place, n in where.most_common(4))]))
    lines += ["", "## By situation", "", "*error*: the median of the step response's, %. *should*: records that count for recall.", ""]
    lines += heading(*GROUPS, "error", "good", "of these wrong", "should", "of these good", "verdicts", "false causes")
    for name, group in situations.items():
        verdicts = Counter(it["standing"] + (f": {it['code']}" if it.get("code") else "") for it in group)
        false = Counter(cause for it in group for cause in several(it.get("false")))
        listed = [", ".join(f"{text} {n}" for text, n in of.most_common()) for of in (verdicts, false)]
        error = sorted(it["error"] for it in group)[len(group) // 2]
        found = counts(group)
        good, should = found["precision"], found["recall"]
        lines.append(line([*name, f"{100 * error:.2g}", good[1], good[1] - good[0], should[1], should[0], *listed]))
    return "\n".join(lines) + "\n"
