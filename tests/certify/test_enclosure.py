"""Enclosures by hand: remainders, cells and peaks of polynomials; where contraction begins and ends."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fixtures.random_models import random_model
from hysgen.certify.certificates import certify
from hysgen.certify.enclosure import (
    ORDER,
    RHO,
    Cells,
    Series,
    _peak,
    _tail,
    gain,
    gain_series,
    slope,
    slope_series,
)
from hysgen.model.membership import memberships
from hysgen.model.model import Grid, Model


def test_tails_are_the_rest_of_their_geometric_series() -> None:
    for x in (0.1, 0.5, 0.8):
        k = np.arange(ORDER, 2000.0)
        assert _tail(np.array([x]), 0) == pytest.approx(np.sum(x**k))
        assert _tail(np.array([x]), 1) == pytest.approx(np.sum((k + 1) * x**k))


def test_a_cell_is_split_in_thirds_that_fill_it() -> None:
    cells = Cells(np.array([1.0, 5.0]), np.array([0.3, 0.6]), np.array([7.0, 8.0])).thirds(np.array([False, True]))
    assert cells.middle == pytest.approx([4.6, 5.0, 5.4])
    assert cells.half == pytest.approx([0.2] * 3)
    assert cells.w.tolist() == [8.0] * 3


@pytest.mark.parametrize(
    ("head", "half", "at", "absolute"),
    [
        ((1.0, 2.0, -4.0), 0.5, 0.25, False),
        ((1.0, 2.0, -4.0), 0.1, 0.1, False),
        ((1.0, -2.0, 0.0), 0.5, -0.5, False),
        ((-1.0, 2.0, -4.0), 0.5, -0.5, True),
        ((1.0, 0.0, 4.0), 0.5, -0.5, False),
    ],
)
def test_the_peak_of_a_polynomial_is_bounded_by_its_quadratic_part_and_the_rest(
    head: tuple[float, ...], half: float, at: float, absolute: bool
) -> None:
    c = np.zeros((1, ORDER))
    c[0, :5] = [*head, 0.25, -0.5]
    value, bound, place = _peak(Series(c, np.array([0.01])), np.array([half]), absolute)
    quadratic = head[0] + head[1] * at + head[2] * at * at
    assert place == pytest.approx(at)
    assert value == pytest.approx(abs(quadratic + 0.25 * at**3 - 0.5 * at**4))
    assert bound == pytest.approx(abs(quadratic) + 0.25 * half**3 + 0.5 * half**4 + 0.01)


@pytest.mark.parametrize("seed", range(4))
def test_the_series_of_gain_and_slope_hold_within_their_remainders(seed: int) -> None:
    """Remainders: gamma/delta times the tail, gamma = sum p_l e^(rho |o_l|) |g_l - mean|, from their definition."""
    model = random_model(seed, rules=4, wild=3.0)
    place = np.array([1.3, 2.0])
    y_um = model.grid.ends_um[0] + model.grid.step_um * place
    p = memberships(y_um, model.grid)
    offset = np.abs(np.arange(4.0) - (p @ np.arange(4.0))[:, None])
    delta = 1.0 - np.sum(p * (np.exp(RHO * offset) - 1.0 - RHO * offset), axis=1)
    for half in (0.2, 0.4):
        cells = Cells(place, np.full(2, half), np.full(2, 37.0))
        found = {gain: gain_series(model)(cells), slope: slope_series(model)(cells)}
        for t in np.linspace(-half, half, 9):
            y = y_um + model.grid.step_um * t
            powers = t ** np.arange(float(ORDER))
            exact = {gain: gain(model, y), slope: slope(model, y, cells.w)}
            for quantity, series in found.items():
                assert (np.abs(series.coefficients @ powers - exact[quantity]) <= series.remainder + 1e-12).all()
        q2 = model.consequents[:, 1]
        gamma = np.sum(p * np.exp(RHO * offset) * np.abs(q2 - (p @ q2)[:, None]), axis=1)
        tail = (half / RHO) ** ORDER / (1.0 - half / RHO)
        assert found[gain].remainder == pytest.approx(gamma / delta * tail)
        opposite = gain_series(model, -1.0)(cells)
        np.testing.assert_allclose(opposite.coefficients, -found[gain].coefficients, rtol=1e-12)


def test_contraction_ends_where_the_slope_of_two_rules_reaches_one() -> None:
    """Two rules of slope a and gains b -+ d, h apart: df/dy = a + 2 d w p_1 p_2 / h, largest where both fire alike."""
    grid = Grid(0.0, 10.0, 2)
    model = Model("m", 1e-3, grid, np.array([[0.5, -0.1, 0.0], [0.5, 0.3, 0.0]]), -200.0, 200.0)
    low, high = certify(model).contracting or (math.nan, math.nan)
    # 0.5 + 0.01 w = 1 and -1.
    assert (low, high) == pytest.approx((-150.0, 50.0), rel=1e-4)
    assert high < 50.0
    assert low > -150.0
    for a, inputs in ((0.999, (-200.0, 200.0)), (1.0, None), (-1.0, None), (-0.999, (-200.0, 200.0))):
        alike = Model("m", 1e-3, grid, np.array([[a, 0.1, 0.0]] * 2), -200.0, 200.0)
        assert certify(alike).contracting == inputs
