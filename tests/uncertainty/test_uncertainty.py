"""Uncertainty: the budget against GTC and Monte Carlo, the sensor's statement, repeatability, coverage."""

import math

import pytest

from fixtures.tools import library
from hysgen.uncertainty.gum import Budget, Contribution, rectangular
from hysgen_lab.studies.coverage import coverage

EXAMPLE = Budget(
    "worked example of docs/uncertainty.md",
    (
        Contribution("sensor", 0.0025, "B", "5 nm, k = 2"),
        Contribution("repeatability", 0.0030, "A", "60 visits", 59.0),
        Contribution("model error", 0.0060, "A", "80 independent samples", 79.0),
        rectangular("drift", 0.0040, "at most 4 nm"),
    ),
)


def test_worked_example_agrees_with_gtc() -> None:
    library("GTC")
    from GTC import dof, uncertainty, ureal
    from GTC.reporting import k_factor

    total = sum(ureal(0.0, c.standard_um, c.freedom) for c in EXAMPLE.contributions)
    assert EXAMPLE.combined_um == pytest.approx(uncertainty(total), rel=1e-12)
    assert EXAMPLE.freedom == pytest.approx(dof(total), rel=1e-12)
    assert EXAMPLE.factor == pytest.approx(k_factor(math.floor(dof(total))), rel=1e-6)


@pytest.mark.proof
def test_expanded_uncertainty_holds_the_truth_of_virtual_stages() -> None:
    """`python -m hysgen_lab.studies.coverage --stages 1000` tries more; 95 % is stated."""
    found = coverage(60)
    assert 0.91 <= found.share <= 0.99, found


def test_one_virtual_stage_is_covered() -> None:
    found = coverage(2, seed=1)
    assert found.share > 0.8
    assert 0.0 < found.sensor < 1.0
