"""The columns of a Preisach operator, computed in blocks of samples and of plays, are those of its definition."""

import numpy as np
import pytest
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from hysgen.machine.kernels.operators import PreisachBasis, play_operators, preisach_columns, preisach_path
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
