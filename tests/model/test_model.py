"""The model: partition, memberships, refusals, and the paper's appendices."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fixtures.printed_models import PRINTED_CENTRES_UM, PRINTED_CONSEQUENTS, PRINTED_SIGMA_UM
from hysgen.errors import ModelError
from hysgen.model.disturbances.periodic import Periodic
from hysgen.model.file import load_model
from hysgen.model.model import Grid, Model
from hysgen.model.regression import membership_slopes, memberships, rule_regressors

GRIDS = st.builds(
    lambda low, span, rules: Grid(low, low + span, rules),
    st.floats(-200, 200),
    st.floats(1e-3, 100),
    st.integers(2, 60),
)


@given(GRIDS, st.floats(-1, 2))
@settings(max_examples=100)
def test_memberships_are_the_normalised_gaussians_of_equations_2_and_3(grid: Grid, place: float) -> None:
    y = grid.y_min_um + place * (grid.y_max_um - grid.y_min_um)
    clamped = min(max(y, grid.y_min_um), grid.y_max_um)
    sigma = (grid.y_max_um - grid.y_min_um) / (grid.rules - 1)
    centres = [grid.y_min_um + sigma * rule for rule in range(grid.rules)]
    mu = np.array([np.exp(-((clamped - c) ** 2) / (2 * sigma**2)) for c in centres])
    p = memberships(np.array([y]), grid)[0]
    # Centres near 200 um on a step of 2e-5 um are known to 1e-9 of a step: that is what the exponent can differ by.
    np.testing.assert_allclose(p, mu / mu.sum(), rtol=1e-6, atol=1e-15)
    assert abs(p.sum() - 1.0) < 1e-14


@given(GRIDS, st.floats(0.01, 0.99))
@settings(max_examples=100)
def test_membership_slopes_are_the_derivatives(grid: Grid, place: float) -> None:
    y = np.array([grid.y_min_um + place * (grid.y_max_um - grid.y_min_um)])
    step = 1e-4 * grid.step_um
    difference = (memberships(y + step, grid) - memberships(y - step, grid)) / (2 * step)
    # Central differences over 1e-4 of a step: 1e-8 by curvature, 1e-8 by the 1e-9 to which y is known in steps.
    np.testing.assert_allclose(membership_slopes(y, grid) * grid.step_um, difference * grid.step_um, atol=1e-4, rtol=0)


def test_regressors_of_the_rules_are_those_of_equation_9() -> None:
    grid = Grid(1.0, 3.0, 3)
    row = rule_regressors(np.array([1.7]), np.array([40.0]), grid)[0]
    p = memberships(np.array([1.7]), grid)[0]
    np.testing.assert_array_equal(row, np.ravel([[p_l * 1.7, p_l * 40.0, p_l] for p_l in p]))


def test_parameters_keep_the_order_of_equation_9_and_drop_scores_and_certificates() -> None:
    consequents = np.array([[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]])
    terms, weights = (Periodic((50.0,)),), np.array([6.0, 7.0])
    known: dict[str, Any] = {"history": {"fit": 0}, "scores": {"a": 1}, "certificates": {"b": 2}}
    model = Model("m", 1e-3, Grid(0.0, 1.0, 2), consequents, 0.0, 1.0, terms, weights, **known)
    np.testing.assert_array_equal(model.parameters, np.arange(8.0))
    other = model.with_parameters(model.parameters + 1.0)
    np.testing.assert_array_equal(other.parameters, np.arange(8.0) + 1.0)
    assert other.history == {"fit": 0}
    assert other.scores == {}
    assert other.certificates == {}


FAULTS: dict[str, dict[str, Any]] = {
    "name: 'Stage 1' cannot prefix": {"name": "Stage 1"},
    "consequents: shape (3, 3) does not fit 2 rules": {"consequents": np.zeros((3, 3))},
    "weights: 1 given, but the terms have 2 regressors": {"weights": np.zeros(1)},
    "parameters: not all finite": {"consequents": np.full((2, 3), np.nan)},
    "Ts_s: 0.0 is not a sampling period": {"Ts_s": 0.0},
    "input range: 1.0 .. 1.0 V is empty": {"u_min_V": 1.0},
    "terms: periodic, periodic: a kind of term may stand once": {
        "terms": (Periodic((50.0,)), Periodic((60.0,))),
        "weights": np.zeros(4),
    },
}


@pytest.mark.parametrize(("message", "changes"), FAULTS.items(), ids=list(FAULTS))
def test_a_model_that_contradicts_itself_is_refused_in_one_line(message: str, changes: dict[str, Any]) -> None:
    sound: dict[str, Any] = {
        "name": "m",
        "Ts_s": 1e-3,
        "grid": Grid(0.0, 1.0, 2),
        "consequents": np.zeros((2, 3)),
        "u_min_V": 0.0,
        "u_max_V": 1.0,
        "terms": (Periodic((50.0,)),),
        "weights": np.zeros(2),
    }
    Model(**sound)
    with pytest.raises(ModelError) as refusal:
        Model(**(sound | changes))
    assert message in str(refusal.value)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    ("low", "high", "rules"), [(1.0, 1.0, 6), (2.0, 1.0, 6), (0.0, np.inf, 6), (0, 1, 1), (0, 1, 999)]
)
def test_an_empty_range_or_too_few_rules_are_refused(low: float, high: float, rules: int) -> None:
    with pytest.raises(ModelError, match=r"grid: the range|rules: "):
        Grid(low, high, rules)


@pytest.mark.parametrize("name", PRINTED_CENTRES_UM)
def test_shipped_appendices_are_the_papers_tables(name: str) -> None:
    model = load_model(name)
    np.testing.assert_array_equal(model.consequents, PRINTED_CONSEQUENTS[name])
    # The ends of the range are printed to 1e-4 um and so are the centres between them: at most 1e-4 apart.
    np.testing.assert_allclose(model.grid.centres_um, PRINTED_CENTRES_UM[name], atol=1.0001e-4, rtol=0)
    # sigma is the range, known to 1e-4 um, over five steps, and printed to 1e-4 um.
    assert abs(model.grid.step_um - PRINTED_SIGMA_UM[name]) < 0.7e-4
    assert (model.u_min_V, model.u_max_V, model.Ts_s) == (-20.0, 120.0, 2e-5)
