"""Noise floor on noise of a known size, and the properties of a series by hand."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from hysgen.record import Record, Segment
from hysgen.record.noise import NoiseFloor, noise_floor
from hysgen.record.series import first_covering, period_of, plateaus, resolution_um, turning_rows, white_noise

Floats = NDArray[np.float64]
TS_S = 1e-3
RNG = np.random.default_rng(11)


def record_of(*runs: tuple[Floats, Floats]) -> Record:
    return Record.from_segments([Segment(str(i), u, y) for i, (u, y) in enumerate(runs)], TS_S)


@pytest.mark.parametrize("samples", [40, 300, 5000])
def test_white_noise_of_a_slow_motion_is_found_beside_lines_and_wrong_readings(samples: int) -> None:
    k = np.arange(samples)
    slow_um = 5.0 * np.sin(2 * np.pi * k / 5000)
    noisy_um = slow_um + RNG.normal(size=(10_000 // samples + 1, samples))
    found_um = [noise_floor(record_of((slow_um, y_um))).rms_um for y_um in noisy_um]
    assert float(np.mean(found_um)) == pytest.approx(1.0, rel=0.06)
    line_um = np.where(k % 900 == 450, 1e3, 80.0 * np.sin(0.9 * k + 0.3))
    both = noise_floor(record_of((slow_um, slow_um + line_um + RNG.normal(size=samples))))
    assert both.rms_um == pytest.approx(1.0, rel=0.6 if samples < 64 else 0.2)
    assert both.method == "spectra"


def test_noise_is_looked_for_where_the_voltage_moves_least() -> None:
    """Of 20 000 rows the fast ones lose 100 times the noise, the slow tenth and a little more has the noise alone."""
    u_V = np.concatenate([40.0 * RNG.normal(size=18_000), np.zeros(4000)])
    noisy_um = RNG.normal(size=u_V.size) * np.repeat([100.0, 1.0], [18_000, 4000])
    found = noise_floor(record_of((u_V, noisy_um)))
    # Windows of 64 rows every 32: a tenth of 686, each with the frequencies from 3 to 31.
    assert (found.samples, found.rms_um) == (68 * 29, pytest.approx(1.0, rel=0.1))


@pytest.mark.parametrize("samples", [249, 600])
def test_what_repeats_with_the_voltage_is_no_noise(samples: int) -> None:
    k = np.arange(samples)
    u_V = np.sin(2 * np.pi * k / 100)
    fast_um = np.tile(RNG.normal(size=100), 6)[:samples]
    # A transient of the first period, which is left out from three periods on.
    first_um = 50.0 * RNG.normal(size=samples) * (k < 100) * (samples >= 300)
    found = noise_floor(record_of((u_V, fast_um + first_um + 0.1 * RNG.normal(size=samples))))
    assert (found.method, found.rms_um) == ("periods", pytest.approx(0.1, rel=0.25))


def test_the_steps_of_a_sensor_are_noise_while_it_rests() -> None:
    u_V = np.repeat([0.0, 5.0, 2.0], 200)
    found = noise_floor(record_of((u_V, 0.3 * u_V)))
    assert found.rms_um == pytest.approx(0.3 * 2.0 / math.sqrt(12.0))


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
    assert noise_floor(record_of((np.arange(15.0), np.arange(15.0)))) == NoiseFloor(0.0, "spectra", 0)
    assert noise_floor(record_of((np.arange(16.0), np.arange(16.0)))).samples > 0


@pytest.mark.parametrize("at", [64, 65], ids=["in the first look", "beside it"])
def test_a_period_is_found_and_refused_by_the_rms_of_all_differences(at: int) -> None:
    u_V = np.tile(np.cumsum(RNG.normal(size=500)), 2)
    limit_V = 1e-3 * float(u_V.std()) * math.sqrt(500.0)
    for share, period in ((0.9, 500), (1.1, None)):
        moved = u_V.copy()
        moved[500 + at] += share * limit_V
        assert period_of(moved) == period
