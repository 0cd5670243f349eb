"""A policy that was trained in an environment of `planesman.gym`: from an observation to values of inputs. It needs Python alone.

A layer is `tanh(W^T x + b)`; the first one takes the observation divided by `scale`, the last one gives actions in -1 to 1, each of which is a value between the two
that `actions` has for it. The file is JSON:

    {"observations": ["depth_error", ...], "scale": [2.0, ...],
     "layers": [{"weights": [[...], ...], "biases": [...]}, ...], "actions": {"stern_planes": [-0.3, 0.3]}}
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path


class Policy:
    def __init__(self, file: str | Path) -> None:
        """Of a file. A file of another form is refused: `ValueError`."""
        written = json.loads(Path(file).read_text())
        try:
            self.observations = [str(name) for name in written["observations"]]
            self.scale = [float(size) for size in written["scale"]]
            self.actions = {str(name): (float(least), float(most)) for name, (least, most) in written["actions"].items()}
            layers = [(layer["weights"], layer["biases"]) for layer in written["layers"]]
            self.layers = [([[float(w) for w in row] for row in rows], [float(b) for b in biases]) for rows, biases in layers]
        except (KeyError, TypeError) as error:
            raise ValueError(f"'{file}' is no policy: {error!r}") from None
        width = len(self.observations)
        for rows, biases in self.layers:
            if len(rows) != width or any(len(row) != len(biases) for row in rows):
                raise ValueError(f"'{file}' is no policy: a layer takes {len(rows)} numbers, and {width} come")
            width = len(biases)
        if width != len(self.actions) or len(self.scale) != len(self.observations):
            raise ValueError(f"'{file}' is no policy: {width} numbers for {len(self.actions)} actions")

    def __call__(self, observation: Mapping[str, float]) -> dict[str, float]:
        """The value of each input, in its unit, for an observation by its names."""
        numbers = [observation[name] / size for name, size in zip(self.observations, self.scale)]
        for rows, biases in self.layers:
            sums = [sum(x * row[j] for x, row in zip(numbers, rows)) + bias for j, bias in enumerate(biases)]
            numbers = [math.tanh(x) for x in sums]
        spans = self.actions.items()
        return {name: least + 0.5 * (action + 1.0) * (most - least) for action, (name, (least, most)) in zip(numbers, spans)}
