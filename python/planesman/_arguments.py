"""Python values as arguments of the command line, whose parser has names, defaults, units and checks."""

from __future__ import annotations

import difflib
import os
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from planesman._native import PlanesmanError

# Options of which each pair is FROM..TO; None is an open end.
_SPANS = ("window", "prefilter", "validation")


def text(value: object) -> str:
    """A value as the command line writes it. Numbers keep every digit.

    Bytes are no text: they raise `TypeError`; nor are lone surrogates, as in the name of a file that is not UTF-8: `PlanesmanError`.
    """
    if isinstance(value, (bytes, bytearray, memoryview)):
        raise TypeError(f"text is expected, not {bytes(value)!r}")
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    if isinstance(value, (float, np.floating)):
        return repr(float(value))
    if isinstance(value, os.PathLike):
        return text(os.fsdecode(value))
    if isinstance(value, Iterable) and not isinstance(value, str):
        return "[" + ", ".join(text(item) for item in value) + "]"
    return _encoded(str(value), str.encode)


def path_text(value: str | bytes | os.PathLike[str] | os.PathLike[bytes]) -> str:
    """A path as `open` takes it, of bytes too. The bytes of a name that are not UTF-8 are surrogates in it, as Python has them."""
    return _encoded(os.fsdecode(value), os.fsencode)


def _encoded(value: str, encode: Callable[[str], bytes]) -> str:
    try:
        encode(value)
    except UnicodeEncodeError as error:
        raise PlanesmanError(f"{value!r} refused: {error.reason} at position {error.start}") from None
    return value


def arguments(options: Mapping[str, Any]) -> list[str]:
    """`{"order": 3, "at_rest": True}` as `--order=3 --at-rest`; None and False are left out."""
    arguments = []
    for name, value in options.items():
        option = "--" + name.replace("_", "-")
        if value is None or value is False:
            continue
        if value is True:
            arguments.append(option)
        elif name in _SPANS and isinstance(value, (tuple, list)):
            spans = value if value and isinstance(value[0], (tuple, list)) else [value]
            arguments += [f"{option}={_span(name, span)}" for span in spans]
        elif name == "heave" and not isinstance(value, str):
            arguments.append(f"{option}={','.join(map(text, value))}")
        else:
            arguments.append(f"{option}={text(value)}")
    return arguments


def _span(name: str, span: object) -> str:
    if not isinstance(span, (tuple, list)) or len(span) != 2:
        raise TypeError(f"{name}: (from, to) is expected, or a list of such; None is an open end")
    return "..".join("" if edge is None else text(edge) for edge in span)


def check_names(function: str, given: Iterable[str], known: Iterable[str]) -> None:
    """Refuse a keyword that the function does not have, in Python's words."""
    names = list(known)
    for name in given:
        if name not in names:
            near = difflib.get_close_matches(name, names, n=1)
            meant = f"; did you mean '{near[0]}'?" if near else ""
            raise TypeError(f"{function}() got an unexpected keyword argument '{name}'{meant}")


def paths(data: str | os.PathLike[str] | Iterable[str | os.PathLike[str]]) -> list[str]:
    """One path, or several, behind `--`: none is taken for an option."""
    several = [data] if isinstance(data, (str, bytes, bytearray, os.PathLike)) else data
    return ["--", *map(path_text, several)]
