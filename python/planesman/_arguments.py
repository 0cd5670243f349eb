"""Converts Python values for the native module, which knows names, defaults, units and checks."""

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
    """A value in its command-line form. Numbers keep all digits.

    Bytes raise `TypeError`. Lone surrogates, as in a file name that is not UTF-8, raise `PlanesmanError`.
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
    """A path, of text or bytes, as `open` accepts it. Bytes that are not UTF-8 become surrogates, as usual in Python."""
    return _encoded(os.fsdecode(value), os.fsencode)


def _encoded(value: str, encode: Callable[[str], bytes]) -> str:
    try:
        encode(value)
    except UnicodeEncodeError as error:
        raise PlanesmanError(f"{value!r} refused: {error.reason} at position {error.start}") from None
    return value


def keywords(options: Mapping[str, Any]) -> dict[str, Any]:
    """The given options: numbers as numbers, everything else as text."""
    found: dict[str, Any] = {}
    for name, value in options.items():
        if value is None or value is False:
            continue
        if name in _SPANS and isinstance(value, (tuple, list)):
            spans = value if value and isinstance(value[0], (tuple, list)) else [value]
            found[name] = _spans(name, spans)
        elif name == "heave" and not isinstance(value, str):
            values = list(value)
            found[name] = values if all(map(_is_number, values)) else ",".join(map(text, values))
        else:
            found[name] = value if isinstance(value, (bool, np.bool_)) or _is_number(value) else text(value)
    return found


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)


def _spans(name: str, spans: Iterable[Any]) -> Any:
    """Pairs (from, to); as text if one of the two is not a number."""
    for span in spans:
        if not isinstance(span, (tuple, list)) or len(span) != 2:
            raise TypeError(f"{name}: (from, to) is expected, or a list of such pairs; None means an open end")
        if not all(edge is None or _is_number(edge) for edge in span):
            return "..".join("" if edge is None else text(edge) for edge in span)
    return [tuple(span) for span in spans]


def check_names(function: str, given: Iterable[str], known: Iterable[str]) -> None:
    """Refuse an unknown keyword with Python's message."""
    names = list(known)
    for name in given:
        if name not in names:
            near = difflib.get_close_matches(name, names, n=1)
            meant = f"; did you mean '{near[0]}'?" if near else ""
            raise TypeError(f"{function}() got an unexpected keyword argument '{name}'{meant}")


def paths(data: str | os.PathLike[str] | Iterable[str | os.PathLike[str]]) -> list[str]:
    """One path, or several."""
    several = [data] if isinstance(data, (str, bytes, bytearray, os.PathLike)) else data
    return list(map(path_text, several))
