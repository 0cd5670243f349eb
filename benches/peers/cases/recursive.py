"""Recursive least squares, row by row, beside padasip."""

from functools import cache

import numpy as np
import padasip

from tools import Missing, best, output, program, seconds

TITLE = "Recursive least squares"
X = "order"
POINTS = [2, 8]
ROWS = 2000
NOTE = "a row has as many past outputs and inputs as the order says, forgetting is 0.99, and the parameters are read after each. Ours is in square-root form."


def contenders():
    return {"planesman": ours, "padasip": peer}


def ours(order: int) -> dict[str, float]:
    return {"a row [us]": seconds(f"recursive least squares, order {order}", output([program("recursive")])) * 1e6}


@cache
def rows(order: int):
    """The rows and outputs of crates/identification/identification/benches/recursive.rs."""
    register, u, y = 1, [0.0] * order, [0.0] * order
    table, outputs = [], []
    for _ in range(ROWS):
        bit = (register ^ register >> 2 ^ register >> 3 ^ register >> 5) & 1
        register = register >> 1 | bit << 15
        table.append([*y[: -order - 1 : -1], *u[: -order - 1 : -1]])
        outputs.append(1.7 * y[-1] - 0.72 * y[-2] + 0.1 * u[-1] + 0.05 * u[-2])
        y.append(outputs[-1])
        u.append(1.0 if bit else -1.0)
    return np.array(table), outputs


def peer(order: int) -> dict[str, float]:
    table, outputs = rows(order)

    def learn():
        made = padasip.filters.FilterRLS(2 * order, mu=0.99, eps=1e-8, w="zeros")
        for row, value in zip(table, outputs):
            made.adapt(value, row)
        return made.w

    found = learn()
    if order == 2 and not np.allclose(found, [1.7, -0.72, 0.1, 0.05], atol=1e-6):
        raise Missing(f"padasip found {found}")
    return {"a row [us]": best(learn, 5) / ROWS * 1e6}
