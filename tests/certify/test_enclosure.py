"""Enclosures by hand: remainders, cells, peaks and slopes of polynomials; where contraction begins and ends."""

import math
from decimal import Context, Decimal, localcontext
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fixtures.random_models import random_model
from hysgen.certify.enclosure import (
    ORDER,
    Cells,
    Series,
    _peak,
    _relative_error,
    _tail,
    gain_series,
    slope_series,
)
from hysgen.certify.path_inverse import POINTS, bounded_slopes, strokes, turning_points


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
    value, bound, place = _peak(Series(c, np.array([0.01]), np.abs(c)), np.array([half]), absolute)
    quadratic = head[0] + head[1] * at + head[2] * at * at
    assert place == pytest.approx(at)
    assert value == pytest.approx(abs(quadratic + 0.25 * at**3 - 0.5 * at**4))
    assert bound == pytest.approx(abs(quadratic) + 0.25 * half**3 + 0.5 * half**4 + 0.01)


def moment(p: list[Decimal], k: int, g: list[Decimal]) -> Decimal:
    """sum p_l g_l l^k / k! over sum p_l."""
    return sum((x * y * rule**k for rule, (x, y) in enumerate(zip(p, g, strict=True))), Decimal(0)) / (
        sum(p) * math.factorial(k)
    )


@pytest.mark.parametrize("rules", [2, 6, 50])
def test_rounding_of_the_series_is_within_what_the_bounds_allow_for(rules: int) -> None:
    """Against 80 digits: the series of sum p_l (v_l + t r_l) e^(t l) over sum p_l e^(t l), at exactly these places."""
    model = random_model(3, rules=rules, wild=3.0)
    cells = Cells(np.linspace(*model.grid.places, 5), np.full(5, 1.0 / 16.0), np.full(5, 37.0))
    step, first = Decimal(model.grid.step_um), Decimal(float(model.grid.ends_um[0]))
    q1, q2, q3 = ([Decimal(float(x)) for x in column] for column in model.consequents.T)
    worst, ones = [], [Decimal(1)] * rules
    for rising, series in ((0, gain_series(model)(cells)), (step, slope_series(model)(cells))):
        for place, found, magnitude in zip(cells.middle, series.coefficients, series.magnitude, strict=True):
            with localcontext(Context(prec=80)):
                s = Decimal(float(place))
                p = [(-((s - rule) ** 2) / 2).exp() for rule in range(rules)]
                v = [a * (first + step * s) + b * 37 + c for a, b, c in zip(q1, q2, q3, strict=True)] if rising else q2

                exact: list[Decimal] = []
                for k in range(ORDER + 1):
                    before = sum((moment(p, j, ones) * exact[k - j] for j in range(1, k + 1)), Decimal(0))
                    exact.append(moment(p, k, v) + (rising * moment(p, k - 1, q1) if k else 0) - before)
                slopes = [(k + 1) * exact[k + 1] / step for k in range(ORDER)] if rising else exact[:ORDER]
                worst += [
                    abs(float(Decimal(float(a)) - b)) / c for a, b, c in zip(found, slopes, magnitude, strict=True)
                ]
    assert 1e-5 * _relative_error(model) < max(worst) < _relative_error(model)


def test_slopes_of_a_hysteresis_are_bounded_part_by_part() -> None:
    """It falls with the input, so every part is turned round: a line, two plays, two Duhem states."""
    series = SimpleNamespace(
        curve=np.array([0.3, -2.0]),
        plays=[np.array([-0.5]), np.array([0.0, 0.25])],
        duhem=np.array([[-0.6, 0.1], [0.2, 0.0]]),
    )
    block: Any = SimpleNamespace(
        mean_slope=-3.0, series=series, ends=(0.8, 0.4), reaches=(0.5, 0.5), low_V=-20.0, high_V=80.0
    )
    found = bounded_slopes(block)
    # Line 2; plays 0.5 and -0.4 .. 0.4; Duhem states 2 (0.6 - 0.2) / 0.5 .. 2 0.6 / 0.5, and -0.8: as parts of 3.
    # (2 - 0.4 - 0.8) / 3 and (2 + 0.5 + 0.4 + 2.4) / 3, nine digits rounded outward.
    assert (found.least, found.largest) == pytest.approx((0.266666666, 1.76666667), rel=1e-12)
    assert (found.mean_um_per_V, found.proved) == (pytest.approx(-0.06), True)


def test_a_path_goes_from_turn_to_turn_and_covers_its_range() -> None:
    first, second = strokes(np.array([0.0, 1.0, -1.0]))
    np.testing.assert_allclose(first, np.linspace(0.0, 1.0, POINTS))
    np.testing.assert_allclose(second, np.linspace(1.0, -1.0, POINTS))
    turns = turning_points(-0.5, 1.0)
    assert turns[:3].tolist() == [-0.5, 1.0, -0.5]
    assert (turns.size, turns.min(), turns.max()) == (3 + 120 + 2 * 60, -0.5, 1.0)
    # A loop is at most half the range wide.
    assert np.abs(np.diff(turns[123:])[::2]).max() == pytest.approx(0.75, rel=0.05)
