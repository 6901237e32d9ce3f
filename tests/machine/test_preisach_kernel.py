"""The columns of a Preisach operator, computed in blocks of samples and of plays, are those of its definition; what no
kernel has room for is refused before it is called."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from hysgen.machine.kernels import call
from hysgen.machine.kernels.operators import (
    Branch,
    LinearPart,
    PreisachBasis,
    duhem_columns,
    play_operators,
    preisach_columns,
    preisach_path,
    softening_states,
)
from hysgen.model.path.hysteresis import FROZEN, RELAXED

Floats = NDArray[np.float64]

SIZES = [(1, 5), (8, 64), (11, 130), (24, 200)]
"""Plays and samples: less than a block of either, exactly one, and more with a rest."""


def _path(samples: int) -> Floats:
    return np.cos(0.21 * np.arange(samples)) * np.cos(0.037 * np.arange(samples))


def _basis(plays: int, relaxation: float = 0.0) -> PreisachBasis:
    """Three hats, of which the last one is empty."""
    radius = np.linspace(0.02, 0.9, plays)
    hat = np.column_stack([1.0 - radius, np.where(radius > 0.3, radius, 0.0), np.zeros(plays)])
    return PreisachBasis(radius, hat, 4, 3, relaxation)


def _expected(v: Floats, z: Floats, basis: PreisachBasis) -> Floats:
    """T_1(v) .. T_4(v), then sum_i hat_ib T_p(z_i) for p = 1 .. 3 and each hat b."""
    rows = [chebyshev.chebval(v, np.eye(5)[m]) for m in range(1, 5)]
    for p in range(1, 4):
        rows += list((chebyshev.chebval(z, np.eye(4)[p]) @ basis.hat).T)
    return np.stack(rows)


@pytest.mark.parametrize(("plays", "samples"), SIZES)
def test_columns_are_sums_of_polynomials_of_plays(plays: int, samples: int) -> None:
    v, basis, start = _path(samples), _basis(plays), np.linspace(-0.1, 0.1, plays)
    out = np.full((4 + 9, samples), np.nan)
    preisach_columns(out, v, start, basis)
    expected = _expected(v, play_operators(v, basis.half_width, start), basis)
    # Recurrence and closed form of a polynomial of degree 4 differ by some roundings of the sum of 24 plays.
    np.testing.assert_allclose(out, expected, rtol=0.0, atol=1e-13)


@pytest.mark.parametrize(("plays", "samples"), SIZES)
def test_columns_of_plays_that_relax_follow_the_equation_of_each_play(plays: int, samples: int) -> None:
    v, basis = _path(samples), _basis(plays, 0.05)
    # From the end of the range, beyond the place to which a play may relax.
    z, now = np.empty((samples, plays)), np.ones(plays)
    s, end = 0.05 * basis.half_width, np.minimum(1.0, 1.0 - basis.half_width + RELAXED * 0.05 * basis.half_width)
    for k in range(samples):
        now = np.clip(now, v[k] - basis.half_width, v[k] + basis.half_width)
        z[k] = now
        way = v[k] - now
        a = np.maximum((basis.half_width - np.abs(way)) / s, 0.0)
        relaxed = np.clip(now + np.copysign(s * np.exp(-a * (1.0 + a / 32.0)), way), -end, end)
        now = np.where(a > FROZEN, now, relaxed)
    out = np.full((4 + 9, samples), np.nan)
    preisach_columns(out, v, np.ones(plays), basis)
    np.testing.assert_allclose(out, _expected(v, z, basis), rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("relaxation", [0.0, 0.05])
@pytest.mark.parametrize(("plays", "samples"), SIZES)
def test_path_is_the_weighted_sum_of_the_columns(plays: int, samples: int, relaxation: float) -> None:
    v, basis, start = _path(samples), _basis(plays, relaxation), np.linspace(-0.1, 0.1, plays)
    weights = np.random.default_rng(1).normal(size=13)
    out = np.empty((13, samples))
    preisach_columns(out, v, start, basis)
    # The same products, added in another order.
    np.testing.assert_allclose(preisach_path(v, start, basis, weights), weights @ out, rtol=0.0, atol=1e-13)
    with pytest.raises(ValueError, match="one weight for each"):
        preisach_path(v, start, basis, weights[1:])


ONE, V = np.array([1.0, -0.5]), np.zeros(10)


def _linear(numerator: Floats = ONE, denominator: Floats = ONE, states: int = 1, branches: int = 1) -> LinearPart:
    return LinearPart(0.0, np.full(states, 0.5), [Branch(1.0, numerator, denominator)] * branches, 0)


def _columns(plays: int, hats: int, degree: int, short: int = 0) -> None:
    basis = PreisachBasis(np.linspace(0.01, 0.9, plays), np.ones((plays, hats)), 2, degree)
    preisach_columns(np.empty((2 + degree * hats - short, 10)), V, np.zeros(plays), basis)


@pytest.mark.parametrize(
    ("made", "most", "beyond", "complaint"),
    [
        (lambda n: _columns(n, 1, 2), 64, 65, "at most 64 plays"),
        (lambda n: _columns(2, n, 2), 64, 65, "128 hats times powers"),
        (lambda n: _columns(2, 1, 2, short=n), 0, 1, "a row for each polynomial"),
        (lambda n: duhem_columns(np.empty((n, 10)), V, np.array([0.5, 0.2])), 4, 3, "two rows for each reach"),
        (lambda n: softening_states(np.zeros((10, n)), np.zeros((1, 6 + 4 * n)), 0.1, 1.0), 16, 17, "and 16 drives"),
        (lambda n: softening_states(np.zeros((10, 1)), np.zeros((n, 10)), 0.1, 1.0), 64, 65, "at most 64 modes"),
        (lambda n: softening_states(np.zeros((10, 2)), np.zeros((1, n)), 0.1, 1.0), 14, 10, "at most 64 modes"),
        (lambda n: _linear(states=n), 64, 65, "at most 64 slow states"),
        (lambda n: _linear(branches=n), 8, 9, "1 to 8 branches"),
        (lambda n: _linear(branches=n), 1, 0, "1 to 8 branches"),
        (lambda n: _linear(np.eye(1, n)[0], np.eye(1, n)[0]), 5, 6, "the same length, 2 to 5"),
        (lambda n: _linear(np.eye(1, n)[0], np.eye(1, n)[0]), 2, 1, "the same length, 2 to 5"),
        (lambda n: _linear(np.eye(1, n)[0]), 2, 3, "the same length, 2 to 5"),
        (lambda n: _linear(denominator=np.array([float(n), 0.5])), 1, 2, "a leading 1 in the denominator"),
        (
            lambda n: call("preisach.c", "hysgen_duhem", 10, V, 1, np.ones(1, f"f{n}"), np.empty((2, 10))),
            8,
            2,
            "C-contiguous arrays of float64",
        ),
    ],
)
def test_a_size_that_a_kernel_has_no_room_for_is_refused(
    made: Callable[[int], Any], most: int, beyond: int, complaint: str
) -> None:
    made(most)
    with pytest.raises(ValueError, match=complaint):
        made(beyond)
