"""Uncertainty: the budget against GTC and Monte Carlo, the sensor's statement, repeatability, coverage."""

import dataclasses
import math

import numpy as np
import pytest

from fixtures.tools import library
from hysgen.record import Record
from hysgen.record.noise import NoiseFloor
from hysgen.uncertainty.gum import Budget, Contribution, SensorUncertainty, independent_samples, rectangular
from hysgen.uncertainty.simulated import Evidence, Repeatability, budget, repeatability
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


def test_worked_example_agrees_with_monte_carlo() -> None:
    """1e5 draws: the half width of their central 95 % is within 2 % of U.

    Its standard error is 0.5 %; draws of Student's t, with their variance nu / (nu - 2), widen it by 0.7 %.
    """
    random = np.random.default_rng(5)
    total = np.zeros(100_000)
    for c in EXAMPLE.contributions:
        if c.shape == "rectangular":
            half = c.standard_um * math.sqrt(3.0)
            total += random.uniform(-half, half, total.size)
        elif math.isfinite(c.freedom):
            total += c.standard_um * random.standard_t(c.freedom, total.size)
        else:
            total += c.standard_um * random.standard_normal(total.size)
    low, high = np.quantile(total, [0.025, 0.975])
    assert 0.5 * (high - low) == pytest.approx(EXAMPLE.expanded_um, rel=0.02)


def test_independent_samples_of_a_first_order_series() -> None:
    """x(k+1) = a x(k) + e(k) has n (1 - a) / (1 + a) of them; the estimate scatters by some ten percent."""
    random = np.random.default_rng(7)
    a, n = 0.9, 40_000
    x = np.zeros(n)
    for k in range(1, n):
        x[k] = a * x[k - 1] + random.standard_normal()
    assert independent_samples(x.tolist()) == pytest.approx(n * (1 - a) / (1 + a), rel=0.2)


@pytest.mark.proof
def test_expanded_uncertainty_holds_the_truth_of_virtual_stages() -> None:
    """`python -m hysgen_lab.studies.coverage --stages 1000` tries more; 95 % is stated."""
    found = coverage(60)
    assert 0.91 <= found.share <= 0.99, found


def test_one_virtual_stage_is_covered() -> None:
    found = coverage(2, seed=1)
    assert found.share > 0.8
    assert 0.0 < found.sensor < 1.0


def record_of_cycles(spread_um: float, noise_um: float, cycles: int, reversal_um: float = 0.0) -> Record:
    """Levels 0, 10, 20, 30 V up and down; positions 0.05 um/V, less `reversal_um` on the way up."""
    random = np.random.default_rng(3)
    levels = ([0.0, 10.0, 20.0, 30.0, 20.0, 10.0] * cycles) + [0.0]
    up = np.sign(np.diff(levels, prepend=10.0))
    u, y = [], []
    for level, direction in zip(levels, up, strict=True):
        place = 0.05 * level + spread_um * random.standard_normal()
        u.append(np.full(40, level))
        y.append(place - reversal_um * (direction > 0) + noise_um * random.standard_normal(40))
    return Record.from_arrays(np.concatenate(u), np.concatenate(y), 1e-3, accept=("constant",))


def test_repeatability_of_repeated_levels() -> None:
    """What a level differs by from below and from above is no spread; a level that is visited once says nothing."""
    cycles = repeatability(record_of_cycles(spread_um=0.002, noise_um=0.001, cycles=40, reversal_um=0.03))
    assert cycles.spread_um == pytest.approx(0.002, rel=0.1)
    assert (cycles.holds, cycles.freedom) == (241, 240 - 6)
    once = repeatability(record_of_cycles(spread_um=0.002, noise_um=0.001, cycles=1))
    assert (once.spread_um, once.freedom, once.holds) == (None, 0, 7)
    moving = Record.from_arrays(np.arange(500.0), np.arange(500.0), 1e-3)
    assert repeatability(moving) == Repeatability(None, 0, 0)


def test_model_error_is_split_by_cause_and_its_sum_is_kept() -> None:
    """A tenth of the action of creep is left, none of that of memory; the split moves neither u_c nor k."""
    random = np.random.default_rng(4)
    t = np.arange(4000.0)
    memory, creep = np.sin(0.01 * t), np.cos(0.003 * t)
    residual = 0.1 * 0.02 * creep + 0.001 * random.standard_normal(t.size)
    plain = Evidence(residual, NoiseFloor(1e-5, "plateaus", 1000), 4000, 20, SensorUncertainty(0.001, 2.0, ""))
    actions = (("memory", 0.05 * memory), ("creep", 0.02 * creep))
    split = budget(dataclasses.replace(plain, actions_um=actions, left_um=(("drift", 2e-4),)))
    parts = {c.name: c.contribution_um for c in split.contributions}
    assert parts["model error, creep"] == pytest.approx(0.1 * 0.02 / math.sqrt(2.0), rel=0.05)
    assert parts["model error, memory"] < 2e-4
    assert parts["model error, drift"] == pytest.approx(2e-4)
    assert parts["model error, rest"] == pytest.approx(0.001, rel=0.05)
    whole = budget(plain)
    assert split.combined_um == pytest.approx(whole.combined_um, rel=1e-12)
    assert split.freedom == pytest.approx(whole.freedom, rel=1e-9)
    assert sum(c.freedom for c in split.contributions if c.name.startswith("model")) == pytest.approx(
        next(c.freedom for c in whole.contributions if c.name == "model error")
    )
