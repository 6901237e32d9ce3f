"""The numbers that a diagnosis reports: each is what its name says, and null where there is none."""

from __future__ import annotations

import dataclasses
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from test_diagnose_signatures import LAG, LINEAR

from hysgen.diagnose import search, trials
from hysgen.diagnose.evidence import periodic
from hysgen.diagnose.noise import innovation
from hysgen.diagnose.probe import Fit, Run, Scene

NOISE_NM = 0.5


class Heard(Exception):  # noqa: N818  it ends a search
    """The noise that a search asked for has been heard."""


def planted(samples: int) -> tuple[Scene, Fit]:
    """A fit that leaves 0.5 nm of white noise and 5 nm of misfit with a period of 400 samples."""
    wave = 5.0 * np.sin(2.0 * np.pi * np.arange(samples) / 400.0)
    left_um = 1e-3 * (wave + NOISE_NM * np.random.default_rng(3).normal(size=samples))
    seen = Scene((Run(np.zeros(samples), left_um, {}),), 1e-4, np.arange(50, samples), LINEAR)
    return seen, Fit(LAG, np.zeros(1), left_um, 1.0)


def test_noise_is_that_between_neighbours_however_long_the_record(monkeypatch: pytest.MonkeyPatch) -> None:
    """Both where the checked rows are compared and where the fitted rows are asked whether they show only noise."""
    seen, fit = planted(300_000)
    better = dataclasses.replace(fit, rms_um=0.1)
    told_nm = {}

    def compared(left_um: Any) -> float:
        told_nm["checked"] = 1e3 * innovation(left_um)
        return innovation(left_um)

    def asked(left_um: Any) -> float:
        told_nm["fitted"] = 1e3 * innovation(left_um)
        raise Heard

    stub = SimpleNamespace(proposals=lambda look: [LAG], promising=lambda found: found, present=lambda chain: False)
    monkeypatch.setattr(trials, "innovation", compared)
    monkeypatch.setattr(search, "innovation", asked)
    monkeypatch.setattr(search, "causes", lambda: {"any": stub})
    monkeypatch.setattr(search, "Look", SimpleNamespace(at=lambda part, fit: None))
    monkeypatch.setattr(search, "_start", lambda part: fit)
    monkeypatch.setattr(search, "_without_spikes", lambda part, fit: (part, np.zeros(0, dtype=bool)))
    monkeypatch.setattr(search, "fitted", lambda part, chains: [better])
    monkeypatch.setattr(search, "refined", lambda part, chains: [better])
    monkeypatch.setattr(search, "ratio", lambda *_: 0.1)
    monkeypatch.setattr(search, "STEP_BELOW", math.inf)
    with pytest.raises(Heard):
        search.search(seen)
    assert told_nm == {name: pytest.approx(NOISE_NM, rel=0.02) for name in ("checked", "fitted")}


def test_a_line_is_held_against_its_neighbours_however_long_the_record() -> None:
    """What stands 1.25 Hz beside a line in 6 s of record is background, also where one row in five is looked at."""
    samples, line_Hz = 60_000, 50.0
    time_s = 1e-4 * np.arange(samples)
    beside_um = np.sin(2.0 * np.pi * (line_Hz + 1.25) * time_s)
    noise_um = 0.1 * np.random.default_rng(4).normal(size=samples)
    seen = Scene((Run(np.zeros(samples), noise_um, {}),), 1e-4, np.arange(samples), LINEAR)
    look = SimpleNamespace(fit=SimpleNamespace(error=beside_um + noise_um), scene=seen)
    dense, _ = periodic._standing(look, line_Hz, 3.0, 0.0)  # type: ignore[arg-type]
    look.scene = search._thinned(seen)
    assert len(look.scene.rows) == search.MOST_ROWS
    thinned, _ = periodic._standing(look, line_Hz, 3.0, 0.0)  # type: ignore[arg-type]
    assert thinned == pytest.approx(dense, rel=0.1)


def test_noise_of_a_sensor_that_resolves_no_more_than_its_noise() -> None:
    """The median of differences that are whole steps is a whole step: 0.60 nm for 0.52 nm behind steps of 1 nm."""
    rng = np.random.default_rng(5)
    left_nm = np.round(rng.normal(scale=0.43, size=40_000) + 40.0 * np.sin(np.arange(40_000) / 3000.0))
    left_nm -= 40.0 * np.sin(np.arange(40_000) / 3000.0)
    assert innovation(left_nm) == pytest.approx(math.hypot(0.43, 1.0 / math.sqrt(12.0)), rel=0.05)
    assert innovation(left_nm[:8000]) > 0.59
