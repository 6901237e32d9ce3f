"""Many columns through the linear part of a stage: creep, then filters side by side, then a delay."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hysgen.machine.kernels.compiled import doubles, kernel

Floats = NDArray[np.float64]

_DECLARATION = """
void hysgen_respond(size_t columns, size_t samples, const double *h, size_t states, double creep, const double *keep,
                    const double *follow, size_t branches, const double *share, const size_t *order,
                    const double *numerator, const double *denominator, long late, size_t row, double *out);
"""
MOST_STATES, MOST_BRANCHES, MOST_ORDER = 64, 8, 4


@dataclass(frozen=True, eq=False)
class Branch:
    """share times numerator/denominator in z^-1, (order + 1,) each, order 1 to 4; the denominator starts with 1."""

    share: float
    numerator: Floats
    denominator: Floats


def responded(
    h: Floats,
    creep: float,
    keep: Floats,
    branches: Sequence[Branch],
    late: int,
    out: Floats,
    first: int = 0,
) -> None:
    """What the linear part makes of each row of h, (m, n), into out[:, first : first + n]; at rest at h(0) before.

        c(k) = x(k) + creep sum_i s_i(k) / 2,    s_i(k+1) = (1 - keep_i) x(k) + keep_i s_i(k),    x = h - h(0)
        y(k) = h(0) + sum of branches of c(k - late)

    keep: (states,) of the slow states. late: in samples; where it is negative, the last value stays at the end.
    Raises ValueError if something has the wrong size.
    """
    orders = np.array([len(branch.numerator) - 1 for branch in branches], dtype=np.uintp)
    if len(keep) > MOST_STATES or not 1 <= len(branches) <= MOST_BRANCHES:
        raise ValueError(f"at most {MOST_STATES} slow states, and 1 to {MOST_BRANCHES} branches")
    if any(
        len(branch.denominator) != order + 1 or not 1 <= order <= MOST_ORDER or branch.denominator[0] != 1.0
        for branch, order in zip(branches, orders.tolist(), strict=True)
    ):
        raise ValueError("numerator and denominator need the same length, 2 to 5, and a leading 1 in the denominator")
    columns, samples = h.shape
    if out.ndim != 2 or len(out) != columns or not 0 <= first <= out.shape[1] - samples:
        raise ValueError("the result needs a row for each row of h, and room for its samples")
    coefficients = np.zeros((2, len(branches), MOST_ORDER + 1))
    for j, branch in enumerate(branches):
        coefficients[0, j, : orders[j] + 1] = branch.numerator
        coefficients[1, j, : orders[j] + 1] = branch.denominator
    library = kernel("response.c", _DECLARATION)
    library.lib.hysgen_respond(
        columns,
        samples,
        doubles(library, np.ascontiguousarray(h)),
        len(keep),
        creep,
        doubles(library, np.ascontiguousarray(keep)),
        doubles(library, 1.0 - keep),
        len(branches),
        doubles(library, np.array([branch.share for branch in branches])),
        library.ffi.from_buffer("size_t *", orders),
        doubles(library, coefficients[0]),
        doubles(library, coefficients[1]),
        late,
        out.shape[1],
        doubles(library, out) + first,
    )
