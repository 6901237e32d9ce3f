"""The numbers that a diagnosis reports: each is what its name says, and null where there is none.

What is wrong, and how sure a gain is: profiles, spectrum, turning points, intervals, noise floor.
"""

import dataclasses
import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fixtures.bank_records import QUICK, record_of
from fixtures.linear_stage import LAG, LINEAR, respond
from hysgen.cli import main
from hysgen.diagnosis import Diagnosis, diagnose, search
from hysgen.diagnosis.causes import Estimate, Residual, causes
from hysgen.diagnosis.error_map import profile, spectrum, turning_points
from hysgen.diagnosis.evaluation import Study, evaluate
from hysgen.diagnosis.ladder import gain
from hysgen.diagnosis.probe import Fit, Scene, Trace, linear_fit
from hysgen.model.disturbances.periodic import Periodic
from hysgen.model.residual import residual_noise
from hysgen.record import Record

NOISE_NM = 0.5


@pytest.fixture(scope="module")
def spiked() -> Record:
    """A stage with memory whose sensor gives a corrupted sample now and then."""
    return record_of("outliers", 4)


@pytest.fixture(scope="module")
def found(spiked: Record, once_per_run: Callable[[str, Callable[[], Any]], Any]) -> Diagnosis:
    diagnosis = once_per_run("spiked", lambda: diagnose(spiked, settings=QUICK))
    assert isinstance(diagnosis, Diagnosis)
    return diagnosis


@pytest.mark.slow
def test_command_line_writes_json_of_a_record_with_corrupted_samples(
    spiked: Record, found: Diagnosis, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A cause that the probe has no part for has no growth of the probe's error: null, not infinity."""

    def known(read: Record, *_: object) -> Study:
        np.testing.assert_array_equal(read.segments[0].y_um, spiked.segments[0].y_um)
        return evaluate(found, spiked, None, 0.65)

    monkeypatch.setattr("hysgen.api.diagnosing.diagnose_and_evaluate", known)
    segment = spiked.segments[0]
    columns = (spiked.Ts_s * np.arange(spiked.samples), segment.u_V, segment.y_um)
    rows = zip(*(column.tolist() for column in columns), strict=True)
    record, result = tmp_path / "spiked.csv", tmp_path / "result.json"
    lines = ["time_s,voltage_V,displacement_um", *(f"{t:.9g},{u!r},{y!r}" for t, u, y in rows)]
    record.write_text("\n".join(lines) + "\n")
    assert main(["diagnose", str(record), "--json", str(result)]) == 0
    outliers, memory = json.loads(result.read_text())["causes"]
    assert (outliers["name"], memory["name"]) == ("outliers", "memory")
    assert outliers["probe_gain"] is None
    assert outliers["confidence"] is None
    assert outliers["gain"]["alone"] is None
    assert memory["probe_gain"] > 10.0
    assert memory["confidence"] == 1.0
    assert memory["gain"]["alone"]["fall_um"] > 0.0


@pytest.mark.slow
def test_a_number_that_is_not_finite_is_null_in_json(found: Diagnosis) -> None:
    unknown = {"per_s": Estimate(1.0, math.inf), "from_s": Estimate(2.0, math.nan)}
    lost = dataclasses.replace(found.causes[1], parameters=unknown, statistic=math.inf)
    result = json.loads(json.dumps(lost.to_json(), allow_nan=False))
    assert result["standard_errors"] == {"per_s": None, "from_s": None}
    assert result["statistic"] is None
    whole = dataclasses.replace(found, causes=(lost,), probe_rms_um=math.nan)
    assert json.loads(json.dumps(whole.to_json(), allow_nan=False))["probe_rms_um"] is None


def planted(samples: int) -> tuple[Scene, Fit]:
    """A fit that leaves 0.5 nm of white noise and 5 nm of misfit with a period of 400 samples."""
    wave = 5.0 * np.sin(2.0 * np.pi * np.arange(samples) / 400.0)
    left_um = 1e-3 * (wave + NOISE_NM * np.random.default_rng(3).normal(size=samples))
    seen = Scene((Trace(np.zeros(samples), left_um, {}),), 1e-4, np.arange(50, samples), LINEAR)
    return seen, Fit(LAG, np.zeros(1), left_um, 1.0)


def test_noise_is_estimated_from_neighbours_at_any_length_of_record() -> None:
    """On all rows, and not on the rows of a fit, which contain one row in forty."""
    seen, fit = planted(300_000)
    part = search.thinned(seen)
    assert len(part.rows) == search.MOST_ROWS
    assert 1e3 * residual_noise(fit.error[part.dense]) == pytest.approx(NOISE_NM, rel=0.02)
    assert 1e3 * residual_noise(fit.error[part.rows]) > 1.2 * NOISE_NM, "the record shows no difference"


def test_a_line_is_compared_with_adjacent_frequencies_at_any_length_of_record() -> None:
    """What stands 1.25 Hz beside a line in 6 s of record is background, also where one row in five is looked at."""
    samples, line_Hz = 60_000, 50.0
    t_s = 1e-4 * np.arange(samples)
    u_V = 50.0 - 50.0 * np.cos(2.0 * np.pi * 0.7 * t_s)
    y_um = 0.1 * respond(u_V, LAG, 1e-4) + 0.1 * np.random.default_rng(4).normal(size=samples)
    y_um += 3.0 * np.sin(2.0 * np.pi * line_Hz * t_s) + np.sin(2.0 * np.pi * (line_Hz + 1.25) * t_s)
    dense = Scene((Trace(u_V, y_um, {}),), 1e-4, np.arange(samples), LINEAR)
    thinned = search.thinned(dense)
    assert len(thinned.rows) == search.MOST_ROWS
    statistics = []
    for seen in (dense, thinned):
        fit = linear_fit(seen, LAG.having(Periodic((line_Hz,))))
        statistics.append(causes()["periodic"].signature(Residual(seen, fit), fit).z)
    assert statistics[1] == pytest.approx(statistics[0], rel=0.05)


def test_spectrum_of_two_samples_is_finite() -> None:
    assert np.isfinite(spectrum(np.array([1.0, -1.0]), 1e-3).rms_um).all()


def test_noise_of_a_sensor_whose_resolution_equals_its_noise() -> None:
    """The median of differences that are whole steps is a whole step: 0.60 nm for 0.52 nm behind steps of 1 nm."""
    rng = np.random.default_rng(5)
    left_nm = np.round(rng.normal(scale=0.43, size=40_000) + 40.0 * np.sin(np.arange(40_000) / 3000.0))
    left_nm -= 40.0 * np.sin(np.arange(40_000) / 3000.0)
    assert residual_noise(left_nm) == pytest.approx(math.hypot(0.43, 1.0 / math.sqrt(12.0)), rel=0.05)
    assert residual_noise(left_nm[:8000]) > 0.59


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
