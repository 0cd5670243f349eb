#!/usr/bin/env python3
"""mdBook's preprocessor of this book: chapters from outside docs/, and links to files that are no chapters.

mdBook would write the chapter ../ARCHITECTURE.md outside the book. Here it gets a place inside, and every link follows it. A link to another
file of the repository (a source, a scenario, a folder) becomes its text, with the file's path as a tooltip: a book has no repository beside it.
"""

import json
import posixpath
import re
import sys

LINK = re.compile(r"(?P<image>!?)\[(?P<text>(?:[^\[\]]|!?\[[^\[\]]*\](?:\([^)]*\))?)*)\]\((?P<target>[^()\s]+)\)")
CODE = re.compile(r"^(?P<fence>```+|~~~+).*?^(?P=fence)\s*$|(?P<ticks>`+)(?!`).+?(?<!`)(?P=ticks)(?!`)", re.DOTALL | re.MULTILINE)


def place(path: str) -> str:
    """Where a file of the repository is in the book: the same path without docs/, a README as the folder's index, as mdBook names it."""
    if path == "docs/README.md":
        return "documents.md"
    folder, name = posixpath.split(path.removeprefix("docs/"))
    return posixpath.join(folder, "index.md" if name == "README.md" else name)


def chapters(items: list) -> list:
    found = []
    for item in items:
        chapter = item.get("Chapter") if isinstance(item, dict) else None
        if chapter:
            found += [chapter, *chapters(chapter["sub_items"])]
    return found


def moved(content: str, path: str, pages: set[str]) -> str:
    """The chapter `path` with links as they are in the book."""

    def link(match: re.Match) -> str:
        image, text, target = match["image"], match["text"], match["target"]
        if ":" in target or target.startswith("#"):
            return match[0]
        file, _, anchor = target.partition("#")
        file = posixpath.normpath(posixpath.join(posixpath.dirname(path), file))
        if file in pages or file.startswith("docs/"):
            target = posixpath.relpath(place(file), posixpath.dirname(place(path)) or ".")
            return f"{image}[{text}]({target}{'#' + anchor if anchor else ''})"
        return f'<span title="{file}">{text}</span>'

    # A link's text may be code; what is in a code block or span is no link.
    kept: list[str] = []

    def hide(match: re.Match) -> str:
        kept.append(match[0])
        return f"\0{len(kept) - 1}\0"

    content = LINK.sub(link, CODE.sub(hide, content))
    return re.sub("\0([0-9]+)\0", lambda it: kept[int(it[1])], content)


def main() -> int:
    if sys.argv[1:2] == ["supports"]:
        return 0
    _, book = json.load(sys.stdin)
    found = [it for it in chapters(book.get("items", book.get("sections"))) if it["path"]]
    pages = {posixpath.normpath(posixpath.join("docs", it["path"])) for it in found}
    for chapter in found:
        path = posixpath.normpath(posixpath.join("docs", chapter["path"]))
        chapter["content"] = moved(chapter["content"], path, pages)
        chapter["path"] = place(path)
    json.dump(book, sys.stdout)
    return 0


if __name__ == "__main__":
    sys.exit(main())
