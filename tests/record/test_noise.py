"""Noise floor, its parts and its choices, computed once more with polynomials and differences of NumPy."""

import math
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from hysgen.model.residual import residual_noise, residual_noise_floor
from hysgen.record import Record, Segment
from hysgen.record.noise import NoiseFloor, noise_floor
from hysgen.record.series import first_covering, period_of, plateaus, resolution_um, turning_rows, white_noise

Floats = NDArray[np.float64]
TS_S = 1e-3
RNG = np.random.default_rng(11)


def record_of(*runs: tuple[Floats, Floats]) -> Record:
    return Record.from_segments([Segment(str(i), u, y) for i, (u, y) in enumerate(runs)], TS_S)


def about(values: Floats, degree: int) -> Floats:
    """Residual about the least-squares polynomial."""
    k = np.arange(values.size)
    fitted: Floats = np.polynomial.Polynomial.fit(k, values, degree)(k)
    return values - fitted


@pytest.mark.parametrize("samples", [249, 299, 302, 550])
def test_noise_from_periods_is_half_the_variance_of_a_period_later(samples: int) -> None:
    """From three periods on the first is left out; the two parameters of the line leave n - 2 degrees of freedom."""
    u_V = np.sin(2 * np.pi * np.arange(samples) / 100)
    y_um = u_V + 0.1 * RNG.normal(size=samples) + 1e-3 * np.arange(samples)
    kept = y_um[100:] if samples >= 300 else y_um
    later = about(kept[100:] - kept[:-100], 1)
    found = noise_floor(record_of((u_V, y_um)))
    assert (found.method, found.samples) == ("periods", later.size - 2)
    assert found.rms_um == pytest.approx(math.sqrt(0.5 * float(later @ later) / (later.size - 2)), rel=1e-9)


def test_noise_from_plateaus_is_about_a_parabola_over_their_last_three_quarters() -> None:
    levels, lengths = [0.0, 40.0, 15.0, 70.0], [61, 80, 40, 41]
    u_V = np.repeat(levels, lengths)
    y_um = RNG.normal(size=u_V.size) + 0.05 * u_V
    edges = np.cumsum([0, *lengths])
    # A plateau needs 41 samples: 40 are one too few, and the last, of 41, counts.
    parts = [about(y_um[a + (b - a - 1) // 4 : b], 2) for a, b in pairwise(edges.tolist()) if b - a > 40]
    freedom = sum(part.size - 3 for part in parts)
    assert len(parts) == 3
    found = noise_floor(record_of((u_V, y_um)))
    assert (found.method, found.samples) == ("plateaus", freedom)
    assert found.rms_um == pytest.approx(math.sqrt(sum(float(p @ p) for p in parts) / freedom), rel=1e-9)


def test_noise_from_differences_is_their_mean_square_over_all_segments() -> None:
    runs = [(np.linspace(0.0, 1.0, n), RNG.normal(size=n)) for n in (12, 90, 11)]
    # Twelve samples are the fewest: six differences of order six. Those of eleven do not count.
    parts = [np.diff(y, 6) for _, y in runs[:2]]
    square = sum(float(d @ d) for d in parts) / math.comb(12, 6)
    found = noise_floor(record_of(*runs))
    assert (found.method, found.samples) == ("differences", 6 + 84)
    assert found.rms_um == pytest.approx(math.sqrt(square / 90), rel=1e-9)


def test_noise_of_a_residual_is_the_median_over_plateaus_that_have_come_to_rest() -> None:
    lag_s, skipped = 2e-3, 24  # twelve time constants of two samples
    u_V = np.repeat([0.0, 5.0, 2.0, 7.0], [140, 120, 39, 100])
    e_um = RNG.normal(size=u_V.size) * np.repeat([1.0, 3.0, 1.0, 2.0], [140, 120, 39, 100])
    parts = [about(e_um[a + skipped : b], 1) for a, b in ((0, 140), (140, 260), (299, 399))]
    record = record_of((u_V, 0.1 * u_V + e_um))
    found = residual_noise_floor(record, e_um, lag_s)
    assert (found.method, found.samples) == ("plateaus", sum(part.size for part in parts))
    expected = math.sqrt(float(np.median([part @ part / (part.size - 2) for part in parts])))
    assert found.rms_um == pytest.approx(expected, rel=1e-9)
    # A plateau with a sample left out does not count; the other two have 76 + 96 samples, fewer than 200.
    e_um[50] = np.nan
    few = residual_noise_floor(record, e_um, lag_s)
    assert (few.method, few.samples) == ("innovation", e_um.size - 2)
    assert few.rms_um == residual_noise(e_um)


@pytest.mark.parametrize(("last", "method"), [(100, "innovation"), (101, "plateaus")])
def test_a_residual_needs_two_hundred_samples_at_rest(last: int, method: str) -> None:
    u_V = np.repeat([0.0, 5.0], [107, last])
    record = record_of((u_V, RNG.normal(size=u_V.size)))
    # At least four samples are left out, however short the lag: 103 + 97 are 200.
    assert residual_noise_floor(record, RNG.normal(size=u_V.size), 1e-9).method == method


def test_periods_of_the_input_come_before_the_residual() -> None:
    u_V = np.sin(2 * np.pi * np.arange(600) / 100)
    record = record_of((u_V, u_V + 0.1 * RNG.normal(size=600)))
    assert residual_noise_floor(record, np.zeros(600), 1e-3) == noise_floor(record)


def test_white_noise_is_the_scale_of_differences_over_that_of_noise() -> None:
    x = np.random.default_rng(2).normal(size=1001)
    x[500] = np.nan
    for order in (2, 6):
        d = np.diff(x, order)
        d = d[np.isfinite(d)]
        root = math.sqrt(math.comb(2 * order, order))
        small = np.sort(np.abs(d))[: int(0.9 * d.size)]
        expected = {
            "median": 1.4826 * np.median(np.abs(d)) / root,
            "rms": math.sqrt(np.mean(d**2)) / root,
            "trimmed": math.sqrt(np.mean(small**2) / 0.62302) / root,
        }
        for scale, value in expected.items():
            assert white_noise(x, order, scale) == pytest.approx(value, rel=1e-12)  # type: ignore[arg-type]
            assert value == pytest.approx(1.0, rel=0.15)
    assert white_noise(np.arange(11.0) ** 7) == 0.0
    assert white_noise(np.arange(12.0) ** 7) > 0.0
    # The mean square of the smaller nine tenths of a normal variable, by its own integral.
    z = np.linspace(-8.0, 8.0, 400_001)
    density = np.exp(-0.5 * z * z) / math.sqrt(2.0 * math.pi)
    inside = np.abs(z) <= 1.6448536269514722
    assert pytest.approx(float((z * z * density)[inside].sum() / density[inside].sum()), rel=2e-4) == 0.62302


def test_properties_of_a_series_by_hand() -> None:
    assert plateaus(np.array([0.0, 0, 0, 1, 1, 2, 2, 2]), 3) == [(0, 3), (5, 8)]
    assert plateaus(np.array([0.0, 0.1, 0.2, 1.0]), 3, 0.15) == [(0, 3)]
    assert plateaus(np.array([0.0, 0.5, 1.0]), 3, 0.5) == [(0, 3)]
    assert plateaus(np.zeros(40)) == [(0, 40)]
    assert plateaus(np.zeros(39)) == []
    assert first_covering(np.array([1.0, 0.0, 97.9, 98.0, 100.0])) == 3
    assert first_covering(np.array([50.0, 100.0, 2.1, 2.0, 0.0])) == 3
    assert resolution_um(np.array([3.0, 1.0, 1.25, 9.0])) == 0.25
    assert resolution_um(np.array([2.0, 2.0])) == 0.0
    assert resolution_um(np.array([0.0, 0.9e-9, 1.0])) == 0.0
    assert resolution_um(np.array([0.0, 1.1e-9, 1.0])) == 1.1e-9
    assert turning_rows(np.array([0.0, 2, 1, 3, 0, 1, 0]), 1.0).tolist() == [3]
    assert turning_rows(np.array([0.0, 2, 1, 3, 0, 1, 0]), 0.9).tolist() == [1, 2, 3, 4, 5]


def test_a_record_too_short_for_any_estimate_has_no_noise_floor_to_show() -> None:
    assert noise_floor(record_of((np.arange(11.0), np.arange(11.0)))) == NoiseFloor(0.0, "differences", 0)


@pytest.mark.parametrize("at", [64, 65], ids=["in the first look", "beside it"])
def test_a_period_is_found_and_refused_by_the_rms_of_all_differences(at: int) -> None:
    u_V = np.tile(np.cumsum(RNG.normal(size=500)), 2)
    limit_V = 1e-3 * float(u_V.std()) * math.sqrt(500.0)
    for share, period in ((0.9, 500), (1.1, None)):
        moved = u_V.copy()
        moved[500 + at] += share * limit_V
        assert period_of(moved) == period
