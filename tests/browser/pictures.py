#!/usr/bin/env python3
"""Makes the pictures of README.md and docs: flies the main job with its page, and what docs/gallery.md says, and draws the pages in Chromium.

    tests/netns.sh .venv/bin/python tests/browser/pictures.py [NAME...]

A name is that of a picture, `dive.webp` or one in docs/gallery.md; all without one. Needs `cargo build --release`, what requirements.txt names,
and Debian's chromium and chromedriver.
"""

import argparse
import os
import re
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from PIL import Image

import browser

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
PATH = f"{ROOT / 'target' / 'release'}:{os.environ['PATH']}"

ANIMATION = "dive.webp"
STILL = "watch.png"
BETWEEN_FRAMES = 1.5
"""s of vehicle time"""
LAST_FRAME = 84.0
"""s of vehicle time: before the page is told that the dive is over"""
NOW = "return import('/charts.js').then((it) => it.samples('/auv/state:depth').times.at(-1) ?? 0)"

TIDY = "document.documentElement.style.scrollbarWidth = 'none'; dispatchEvent(new Event('resize'))"
KEEP = """
const all = [...document.querySelectorAll("figure.plot")];
for (const it of all) it.hidden = !arguments[0].includes(it.querySelector("h2").textContent);
all.find((it) => !it.hidden).scrollIntoView();
dispatchEvent(new Event("resize"));
"""
RECTANGLE = """
const all = [...document.querySelectorAll("figure.plot:not([hidden])")].map((it) => it.getBoundingClientRect());
return [Math.min(...all.map((it) => it.top)) + scrollY, Math.max(...all.map((it) => it.bottom)) + scrollY];
"""
OVER = """
const { left, top, width, height } = document.querySelector("figure.plot:not([hidden]) .u-over").getBoundingClientRect();
return [left, top + height / 2, width];
"""


@dataclass
class Picture:
    """What is seen of a page that the commands of the gallery have made."""

    page: str
    size: tuple[int, int] = (1200, 900)
    plots: tuple[str, ...] = ()
    """Only these plots; the page from its top if empty."""
    second_half: bool = False
    """Whether the second half of the time is zoomed into."""


FLOWN = {
    "flight.png": Picture("runs/good/report.html", size=(1200, 1400)),
    "gallery_too_fast.png": Picture("runs/too_fast.html", plots=("Depth", "Dive planes")),
    "gallery_limit_cycle.png": Picture("runs/limit_cycle.html", plots=("Depth", "Dive planes"), second_half=True),
    "gallery_leaking_valve.png": Picture("runs/leaking_valve.html", plots=("Depth", "Dive planes")),
    "gallery_remus_100.png": Picture("runs/remus_100/report.html", size=(1200, 1150)),
}


def commands() -> dict[str, str]:
    """The commands in docs/gallery.md, by the picture that follows them."""
    text = (DOCS / "gallery.md").read_text()
    return {name: script for script, name in re.findall(r"```sh\n(.*?)```.*?\]\((\w+\.png)\)", text, re.DOTALL)}


def take(driver, picture: Picture, folder: Path, file: Path) -> None:
    """Draws the page that the commands have left in the folder."""
    browser.act(driver, {"size": picture.size})
    browser.act(driver, {"open": f"file://{folder / picture.page}"})
    browser.act(driver, {"run": TIDY})
    if picture.plots:
        browser.act(driver, {"run": KEEP, "with": [picture.plots]})
        time.sleep(1)
        if picture.second_half:
            left, middle, width = browser.act(driver, {"run": OVER})
            browser.act(driver, {"drag": [[left + width / 2, middle], [left + width - 1, middle]]})
        top, bottom = browser.act(driver, {"run": RECTANGLE})
        browser.act(driver, {"size": [picture.size[0], round(bottom - top) + 20]})
        browser.act(driver, {"run": "scrollTo(0, arguments[0])", "with": [top - 10]})
    time.sleep(1)
    browser.act(driver, {"picture": str(file)})


def animate(driver, folder: Path, to: Path) -> None:
    """Flies the main job, three times as fast as real time, with its page."""
    command = ["planesman", "dive", "--watch", "--factor", "3", "--out", "dive"]
    environment = os.environ | {"PATH": PATH}
    flight = subprocess.Popen(command, cwd=folder, env=environment, stdout=subprocess.PIPE, text=True)
    try:
        address = next(line.strip() for line in flight.stdout if line.startswith("http://"))
        browser.act(driver, {"size": [1100, 760]})
        browser.act(driver, {"open": address})
        browser.act(driver, {"run": TIDY})
        frames, due = [], BETWEEN_FRAMES
        while due < LAST_FRAME:
            if browser.act(driver, {"run": NOW}) < due:
                time.sleep(0.05)
                continue
            file = folder / "frame.png"
            browser.act(driver, {"picture": str(file)})
            with Image.open(file) as frame:
                frames.append(frame.convert("RGB").resize((900, 622), Image.Resampling.LANCZOS))
            due += BETWEEN_FRAMES
        browser.act(driver, {"size": [1400, 1000]})
        time.sleep(1)
        browser.act(driver, {"picture": str(to / STILL)})
    finally:
        flight.terminate()
        flight.wait()
    durations = [100] * (len(frames) - 1) + [3000]
    frames[0].save(to / ANIMATION, save_all=True, append_images=frames[1:], duration=durations, loop=0, quality=70, method=4)


def main() -> None:
    scripts = commands()
    assert set(scripts) == set(FLOWN), f"docs/gallery.md has {sorted(scripts)}"
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("names", nargs="*", metavar="NAME", help=", ".join([ANIMATION, *FLOWN]))
    options.add_argument("--to", type=Path, default=DOCS, metavar="FOLDER", help="where they are put [default: docs]")
    chosen = options.parse_args()
    names = chosen.names or [ANIMATION, *FLOWN]
    if unknown := set(names) - {ANIMATION, *FLOWN}:
        options.error(f"there is no picture {', '.join(sorted(unknown))}")
    with tempfile.TemporaryDirectory() as folder, browser.chromium() as driver:
        folder = Path(folder)
        (folder / "launch-scripts").symlink_to(ROOT / "launch-scripts")
        for name in names:
            if name == ANIMATION:
                animate(driver, folder, chosen.to)
            else:
                subprocess.run(["sh", "-ec", scripts[name]], cwd=folder, env=os.environ | {"PATH": PATH}, check=True)
                take(driver, FLOWN[name], folder, chosen.to / name)
            print(chosen.to / name, f"{(chosen.to / name).stat().st_size / 1e3:.0f} kB")


if __name__ == "__main__":
    sys.exit(main())
