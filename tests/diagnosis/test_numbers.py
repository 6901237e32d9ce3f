"""The numbers that a diagnosis reports: each is what its name says, and null where there is none."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fixtures.bank_records import QUICK, record_of
from fixtures.linear_stage import (
    DRIFTING,
    LAG,
    LINEAR,
    scene,
)
from hysgen.cli import main
from hysgen.diagnosis import Diagnosis, diagnose, procedure, search
from hysgen.diagnosis.causes import Estimate, Signature, periodic
from hysgen.diagnosis.causes.drift import DriftPart
from hysgen.diagnosis.error_map import spectrum
from hysgen.diagnosis.evaluation import Study, evaluate
from hysgen.diagnosis.probe import Chain, Fit, Scene, Trace, refine
from hysgen.record import Record
from hysgen.record.series import residual_noise
from hysgen.report.words import parameter_text

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


def test_command_line_writes_json_of_a_record_with_corrupted_samples(
    spiked: Record, found: Diagnosis, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A cause that the probe has no part for has no growth of the probe's error: null, not infinity."""

    def known(read: Record, *_: object) -> Study:
        np.testing.assert_array_equal(read.segments[0].y_um, spiked.segments[0].y_um)
        return evaluate(found, spiked, None, 0.65)

    monkeypatch.setattr("hysgen.cli.verbs.diagnose.diagnose_and_evaluate", known)
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


def test_confidence_is_the_share_of_draws_and_nothing_else(found: Diagnosis) -> None:
    outliers, memory = found.causes
    assert memory.alone is not None
    assert memory.to_json()["confidence"] == memory.alone.confidence
    assert outliers.to_json()["confidence"] is None


def test_a_number_that_is_not_finite_is_null_in_json(found: Diagnosis) -> None:
    unknown = {"per_s": Estimate(1.0, math.inf), "from_s": Estimate(2.0, math.nan)}
    lost = dataclasses.replace(found.causes[1], parameters=unknown, statistic=math.inf)
    result = json.loads(json.dumps(lost.to_json(), allow_nan=False))
    assert result["standard_errors"] == {"per_s": None, "from_s": None}
    assert result["statistic"] is None
    whole = dataclasses.replace(found, causes=(lost,), probe_rms_um=math.nan)
    assert json.loads(json.dumps(whole.to_json(), allow_nan=False))["probe_rms_um"] is None


def test_the_unit_of_a_parameter_is_printed_behind_its_value(found: Diagnosis) -> None:
    rates = {"rate_V_per_s": Estimate(800.0, 3.0), "ramp_um_per_s": Estimate(0.5, math.nan)}
    memory = dataclasses.replace(found.causes[1], parameters={**rates, "per_s": Estimate(0.1, 0.01)})
    study: Any = SimpleNamespace(diagnosis=dataclasses.replace(found, causes=(memory,)))
    assert parameter_text(study, "memory") == "rate 800 ± 3 V/s, ramp 0.5 um/s, per s 0.1 ± 0.01"


def test_error_growth_is_as_measured_if_the_likelihood_separates_the_causes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen = scene(LAG, 2e-3 * np.linspace(0.0, 1.0, 4000))
    same = {
        "forward_step": None,
        "_slow_error_growth": {},
        "ratio_above_noise": 1.0 / 1.05,
        "compare_likelihood": ["drift"],
    }
    for name, answer in same.items():
        monkeypatch.setattr(search, name, lambda *_, answer=answer: answer)
    for name in ("swap_similar_causes", "swap_slow_causes", "eliminate_backward", "restart", "drop_unsupported_parts"):
        monkeypatch.setattr(search, name, lambda part, fit, checked: fit)
    monkeypatch.setattr(search, "likeliest_slow_causes", lambda part, fit: fit.chain)
    monkeypatch.setattr(search, "_start", lambda part: refine(part, DRIFTING))
    ended = search.search(seen)
    assert ended.error_growth == {"drift": pytest.approx(1.05, rel=1e-12)}
    assert ended.separated_by_likelihood == ("drift",)


@pytest.mark.parametrize(
    ("chain", "apart", "why"),
    [
        (DRIFTING, ("drift",), None),
        (DRIFTING, (), "the error grows only 1.05 times without it"),
        # A drift that slows down requires a growth of 3; the likelihood replaces only the growth that a ramp requires.
        (LAG.having(DriftPart(1.0)), ("drift",), "the error grows only 1.05 times without it"),
    ],
)
def test_a_cause_that_the_likelihood_separates_is_needed_at_any_error_growth(
    monkeypatch: pytest.MonkeyPatch, chain: Chain, apart: tuple[str, ...], why: str | None
) -> None:
    monkeypatch.setattr(procedure, "_eliminate_by_gain", lambda *given: (list(given[3]), {}, []))
    seen: Any = SimpleNamespace(
        error_growth={"drift": 1.05}, separated_by_likelihood=apart, fit=SimpleNamespace(chain=chain)
    )
    signatures = {"drift": Signature(True, 9.0, "drifts")}
    named, _, refused = procedure._agreement(None, seen, signatures, {}, QUICK)  # type: ignore[arg-type]
    assert named == ([] if why else ["drift"])
    assert {one.name: one.why for one in refused} == ({"drift": why} if why else {})


def planted(samples: int) -> tuple[Scene, Fit]:
    """A fit that leaves 0.5 nm of white noise and 5 nm of misfit with a period of 400 samples."""
    wave = 5.0 * np.sin(2.0 * np.pi * np.arange(samples) / 400.0)
    left_um = 1e-3 * (wave + NOISE_NM * np.random.default_rng(3).normal(size=samples))
    seen = Scene((Trace(np.zeros(samples), left_um, {}),), 1e-4, np.arange(50, samples), LINEAR)
    return seen, Fit(LAG, np.zeros(1), left_um, 1.0)


def test_noise_is_estimated_from_neighbours_at_any_length_of_record() -> None:
    """On the rows that are compared, and on the rows of a fit, which looks at one row in twenty-five."""
    seen, fit = planted(300_000)
    part, checked = search.split_rows(seen)
    assert len(part.rows) == search.MOST_ROWS
    for rows in (part.dense, checked):
        assert 1e3 * residual_noise(fit.error[rows]) == pytest.approx(NOISE_NM, rel=0.02)
    assert 1e3 * residual_noise(fit.error[part.rows]) > 1.2 * NOISE_NM, "the record shows no difference"


def test_a_line_is_compared_with_adjacent_frequencies_at_any_length_of_record() -> None:
    """What stands 1.25 Hz beside a line in 6 s of record is background, also where one row in five is looked at."""
    samples, line_Hz = 60_000, 50.0
    time_s = 1e-4 * np.arange(samples)
    beside_um = np.sin(2.0 * np.pi * (line_Hz + 1.25) * time_s)
    noise_um = 0.1 * np.random.default_rng(4).normal(size=samples)
    seen = Scene((Trace(np.zeros(samples), noise_um, {}),), 1e-4, np.arange(samples), LINEAR)
    residual = SimpleNamespace(fit=SimpleNamespace(error=beside_um + noise_um), scene=seen)
    dense, _ = periodic._line_significance(residual, line_Hz, 3.0, 0.0)  # type: ignore[arg-type]
    residual.scene = search.thinned(seen)
    assert len(residual.scene.rows) == search.MOST_ROWS
    thinned, _ = periodic._line_significance(residual, line_Hz, 3.0, 0.0)  # type: ignore[arg-type]
    assert thinned == pytest.approx(dense, rel=0.1)


def test_spectrum_of_two_samples_is_finite() -> None:
    assert np.isfinite(spectrum(np.array([1.0, -1.0]), 1e-3).rms_um).all()


def test_noise_of_a_sensor_whose_resolution_equals_its_noise() -> None:
    """The median of differences that are whole steps is a whole step: 0.60 nm for 0.52 nm behind steps of 1 nm."""
    rng = np.random.default_rng(5)
    left_nm = np.round(rng.normal(scale=0.43, size=40_000) + 40.0 * np.sin(np.arange(40_000) / 3000.0))
    left_nm -= 40.0 * np.sin(np.arange(40_000) / 3000.0)
    assert residual_noise(left_nm) == pytest.approx(math.hypot(0.43, 1.0 / math.sqrt(12.0)), rel=0.05)
    assert residual_noise(left_nm[:8000]) > 0.59
