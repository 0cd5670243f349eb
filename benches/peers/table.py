"""The results as Markdown."""

from statistics import median


def ratios(ours: list[float], peer: list[float]) -> list[float]:
    """Ours over the peer's, round by round."""
    return [a / b for a, b in zip(ours, peer)]


def number(value: float) -> str:
    """Three digits, without an exponent."""
    if value == 0:
        return "0"
    if abs(value) >= 999.5:
        return f"{float(f'{value:.3g}'):,.0f}".replace(",", " ")
    return f"{value:.3g}"


def of_case(document: dict, name: str) -> list[dict]:
    return [row for row in document["rows"] if row["case"] == name]


def pairs(rows: list[dict]) -> list[tuple[str, dict, dict, dict]]:
    """Each measure that ours shares with a peer: measure, our row, the peer's row, median costs and ratios."""
    found = []
    for point in dict.fromkeys(row["point"] for row in rows):
        ours, *peers = [row for row in rows if row["point"] == point]
        for peer in peers:
            for measure in ours["costs"]:
                if measure in peer["costs"]:
                    ratio = ratios(ours["costs"][measure], peer["costs"][measure])
                    found.append((measure, ours, peer, ratio))
    return found


def failures(rows: list[dict]) -> list[dict]:
    return [row for row in rows if row["failed"]]


def what(case, row: dict) -> str:
    point = "" if row["point"] is None else f", {case.X} {row['point']}"
    return f"{case.TITLE}{point}"


def markdown(document: dict, cases: dict) -> str:
    """The page: the machine, the table of pairs, the tables of costs against size, and what failed."""
    lines = ["# Beside peers", ""]
    lines.append(f"Made by `benches/peers/run`. A value is the median of the rounds, at most {document['rounds']};")
    lines.append("a ratio is ours over the peer's in the same round: below 1, ours costs less.")
    lines.append("")
    lines += [f"- {name}: {value}" for name, value in {**document["machine"], **document["versions"]}.items()]
    lines += ["", "| what | ours | peer | its cost | ratio: least | median | largest |", "|---|---|---|---|---|---|---|"]
    for name, case in cases.items():
        rows = of_case(document, name)
        for measure, ours, peer, ratio in pairs(rows) if getattr(case, "PEERS", True) else []:
            cells = [f"{what(case, ours)}: {measure}", number(median(ours["costs"][measure])), peer["contender"]]
            cells += [number(median(peer["costs"][measure]))]
            cells += [number(value) for value in (min(ratio), median(ratio), max(ratio))]
            lines.append("| " + " | ".join(cells) + " |")
        for row in failures(rows):
            lines.append(f"| {what(case, row)} | | {row['contender']} | failed: {row['failed']} | | | |")
    for name, case in cases.items():
        if hasattr(case, "POINTS"):
            lines += ["", *growth(case, of_case(document, name)), "", f"![{case.TITLE}](plots/{name}.svg)"]
    notes = [f"- {case.TITLE}: {case.NOTE}" for case in cases.values() if hasattr(case, "NOTE")]
    if notes:
        lines += ["", "## Notes", "", *notes]
    return "\n".join(lines) + "\n"


def growth(case, rows: list[dict]) -> list[str]:
    """The medians at each size, a column for each measure of each contender."""
    columns = list(dict.fromkeys((row["contender"], measure) for row in rows for measure in row["costs"]))
    rounds = max((len(values) for row in rows for values in row["costs"].values()), default=0)
    lines = [f"## {case.TITLE}", "", f"Median of {rounds}." if rounds > 1 else "One round.", ""]
    lines.append(f"| {case.X} | " + " | ".join(f"{contender}: {measure}" for contender, measure in columns) + " |")
    lines.append("|---" * (len(columns) + 1) + "|")
    for point in dict.fromkeys(row["point"] for row in rows):
        costs = {row["contender"]: row["costs"] for row in rows if row["point"] == point}
        cells = [costs.get(contender, {}).get(measure) for contender, measure in columns]
        lines.append(f"| {point} | " + " | ".join(number(median(cell)) if cell else "" for cell in cells) + " |")
    return lines
