"""Prints the messages of a ROS installation as standard/jazzy.txt and humble.txt have them: make.py SHARE_FOLDER PACKAGE...

A line is package/Type=TYPE NAME;TYPE NAME;..., without comments, constants and defaults: names and types are all that a message's bytes depend on.
"""

import pathlib
import re
import sys

share, *packages = sys.argv[1:]
for package in sorted(packages):
    for file in sorted((pathlib.Path(share) / package / "msg").glob("*.msg")):
        lines = (line.split("#")[0].split() for line in file.read_text().splitlines())
        fields = [words[:2] for words in lines if len(words) > 1 and not re.match(r"\w+\s*=", " ".join(words[1:]))]
        print(f"{package}/{file.stem}={';'.join(map(' '.join, fields))}")
