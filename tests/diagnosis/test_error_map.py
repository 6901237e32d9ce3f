"""What is wrong, and how sure a gain is: profiles, spectrum, turning points, intervals, noise floor."""

from __future__ import annotations

import numpy as np
import pytest

from hysgen.diagnosis.error_map import profile, spectrum, turning_points
from hysgen.diagnosis.ladder import gain


def test_a_profile_counts_every_sample_once_and_preserves_the_power() -> None:
    rng = np.random.default_rng(1)
    values, error_um = rng.uniform(0, 5, 4000), rng.normal(size=4000)
    sorted_by = profile("level", "V", values, error_um)
    assert sum(sorted_by.samples) == 4000
    power = sum(count * rms**2 for count, rms in zip(sorted_by.samples, sorted_by.rms_um, strict=True))
    assert power == pytest.approx(float(error_um @ error_um), rel=1e-12)  # a sum in another order


def test_profile_shows_where_the_error_is() -> None:
    values = np.linspace(0, 10, 1000)
    by_level = profile("level", "V", values, np.where(values > 9.0, 1.0, 0.0))
    assert by_level.rms_um[-1] == pytest.approx(1.0, abs=0.01)  # one sample of 100 lies on the edge
    assert max(by_level.rms_um[:-1]) < 0.11


def test_spectrum_shows_a_line_at_its_frequency_with_its_rms() -> None:
    Ts_s = 1e-3
    line_um = 0.3 * np.sin(2 * np.pi * 51.0 * Ts_s * np.arange(8000))
    found = spectrum(line_um, Ts_s)
    strongest = int(np.argmax(found.rms_um))
    assert abs(np.log(found.f_Hz[strongest] / 51.0)) < 0.1  # bands are 15 % wide
    assert np.sqrt(np.sum(np.square(found.rms_um))) == pytest.approx(
        0.3 / np.sqrt(2), rel=0.01
    )  # leakage of the window


def test_turning_points_ignore_noise_on_the_command() -> None:
    rng = np.random.default_rng(2)
    turns = np.array([0, 1000, 2500, 3000, 4200, 4999])
    u_V = np.interp(np.arange(5000), turns, [0.0, 10.0, 2.0, 7.0, 0.0, 9.0]) + 0.01 * rng.normal(size=5000)
    found = turning_points(u_V)
    assert len(found) == len(turns)
    assert np.abs(found - turns).max() <= 10  # the top is as flat as the noise: 0.01 V at 0.01 V per sample, some times


def test_interval_of_a_gain_covers_it_although_errors_are_correlated() -> None:
    covered = 0
    for seed in range(60):
        rng = np.random.default_rng(seed)
        slow = np.convolve(rng.normal(size=4200), np.ones(100) / 10.0, mode="valid")[:4000]
        found = gain(1.5 * slow, slow)
        truth = 0.5  # the filter leaves unit variance
        covered += found.low_um <= truth <= found.high_um
    # 95 % nominal; 24 blocks of 40 independent stretches leave some out. 45 of 60 is 6 standard deviations above 1/2,
    # and independent resampling of single samples covers fewer than 20.
    assert covered >= 45
