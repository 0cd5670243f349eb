#!/usr/bin/env python3
"""Checks the links of the documents: files, folders, images, and the anchors within documents.

    .ci/links.py                     # every document under version control, as GitHub shows it
    .ci/links.py --book target/book  # also each page of the built book (docs/book.toml)

Each broken link is a line `FILE:LINE: link: what is wrong`; the exit status is then 1. A document of docs/ that docs/SUMMARY.md does not list is an
error too. Addresses on the web are counted and not opened.
"""

import argparse
import functools
import html.parser
import re
import subprocess
import sys
import urllib.parse
from pathlib import Path

FENCE = re.compile(r"^ {0,3}(```+|~~~+)")
SPAN = re.compile(r"(?<!`)(`+)(?!`)(.+?)(?<!`)\1(?!`)")
HEADING = re.compile(r"^ {0,3}#{1,6}\s+(.*?)\s*#*\s*$")
LINK = re.compile(r"\]\(\s*<?([^()\s<>]*(?:\([^()\s]*\)[^()\s<>]*)*)>?(?:\s+(?:\"[^\"]*\"|'[^']*'))?\s*\)")
DEFINITION = re.compile(r"^ {0,3}\[[^\]]+\]:\s*<?(\S+?)>?(?:\s|$)")
TAG = re.compile(r"<(?:a|img)\b[^>]*?\b(?:href|src)=\"([^\"]+)\"")
ID = re.compile(r"<[a-z0-9]+\b[^>]*?\b(?:id|name)=\"([^\"]+)\"")


def lines_outside_code(text: str) -> list[tuple[int, str]]:
    """The lines, numbered from 1, without fenced blocks."""
    lines, fence = [], None
    for number, line in enumerate(text.splitlines(), 1):
        mark = FENCE.match(line)
        if fence is None and not mark:
            lines.append((number, line))
        elif fence is None:
            fence = mark[1]
        elif mark and mark[1].startswith(fence) and line.strip() == mark[1]:
            fence = None
    return lines


def slug(heading: str) -> str:
    """The anchor of a heading, as GitHub makes it."""
    text = SPAN.sub(lambda it: it[2], heading)
    text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", text)
    text = re.sub(r"<[^>]+>", "", text) if "`" not in heading else text
    kept = "".join(it for it in text.strip().lower() if it.isalnum() or it in " -_")
    return kept.replace(" ", "-")


@functools.cache
def anchors(file: Path) -> frozenset[str]:
    counts: dict[str, int] = {}
    found = set()
    for _, line in lines_outside_code(file.read_text(encoding="utf-8")):
        found.update(ID.findall(line))
        if heading := HEADING.match(line):
            name = slug(heading[1])
            again = counts[name] = counts.get(name, -1) + 1
            found.add(f"{name}-{again}" if again else name)
    return frozenset(found)


def links(file: Path) -> list[tuple[int, str]]:
    found = []
    for number, line in lines_outside_code(file.read_text(encoding="utf-8")):
        # What is in code is no link; a link around code is one.
        line = SPAN.sub("code", line)
        found += [(number, it) for it in LINK.findall(line) + DEFINITION.findall(line) + TAG.findall(line)]
    return found


def wrong(file: Path, link: str, tracked: set[Path]) -> str | None:
    """What is wrong with a link of a document; None if nothing is."""
    path, _, anchor = link.partition("#")
    target = file if not path else (file.parent / urllib.parse.unquote(path)).resolve()
    if not target.exists():
        return "there is no such file"
    if target not in tracked:
        return "it is not under version control"
    if anchor and target.suffix != ".md":
        return "an anchor in a file that is no document"
    if anchor and anchor not in anchors(target):
        return f"{target.name} has no such heading"
    return None


class Page(html.parser.HTMLParser):
    """The links and the anchors of a page of the book."""

    def __init__(self, text: str):
        super().__init__()
        self.links: list[tuple[int, str]] = []
        self.anchors: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name == "id":
                self.anchors.add(value)
            elif (tag, name) in {("a", "href"), ("img", "src"), ("script", "src"), ("link", "href")} and value:
                self.links.append((self.getpos()[0], value))


def wrong_in_book(file: Path, link: str, pages: dict[Path, Page]) -> str | None:
    path, _, anchor = link.partition("#")
    target = file if not path else (file.parent / urllib.parse.unquote(path)).resolve()
    if target.is_dir():
        target /= "index.html"
    if not target.exists():
        return "the book has no such file"
    if anchor and anchor not in pages[target].anchors:
        return f"{target.name} has no such heading"
    return None


def is_elsewhere(link: str) -> bool:
    return bool(re.match(r"[a-z][a-z0-9+.-]*:|//", link, re.IGNORECASE))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--book", type=Path, help="the folder of the built book")
    book = parser.parse_args().book
    root = Path(__file__).resolve().parent.parent
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=root, check=True, capture_output=True, text=True).stdout
    files = [root / it for it in listed.split("\0") if it]
    # A folder is there when a file of it is.
    tracked = {parent for file in files for parent in [file, *file.parents]}
    documents = [it for it in files if it.suffix == ".md"]

    complaints, inside, outside = [], 0, 0
    for file in documents:
        for number, link in links(file):
            if is_elsewhere(link):
                outside += 1
                continue
            inside += 1
            if problem := wrong(file, link, tracked):
                complaints.append(f"{file.relative_to(root)}:{number}: {link}: {problem}")
    summary = root / "docs/SUMMARY.md"
    chapters = {(summary.parent / link).resolve() for _, link in links(summary)}
    for file in documents:
        if file.parent == summary.parent and file != summary and file not in chapters:
            complaints.append(f"{file.relative_to(root)}: not in docs/SUMMARY.md")
    print(f"{len(documents)} documents: {inside} links within the repository checked, {outside} to the web not opened")

    if book:
        # 404.html is for servers, which show it for any address.
        names = [it for it in sorted(book.resolve().rglob("*.html")) if it.name not in {"404.html", "toc.html"}]
        pages = {it: Page(it.read_text(encoding="utf-8")) for it in names}
        count = 0
        for file, page in pages.items():
            for number, link in page.links:
                if not is_elsewhere(link):
                    count += 1
                    if problem := wrong_in_book(file, link, pages):
                        complaints.append(f"{file.relative_to(book.resolve())}:{number}: {link}: {problem}")
        print(f"{len(pages)} pages of the book: {count} links checked")
        if len(pages) < len(chapters):
            complaints.append(f"the book has {len(pages)} pages for {len(chapters)} chapters")
    for complaint in complaints:
        print(complaint, file=sys.stderr)
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main())
