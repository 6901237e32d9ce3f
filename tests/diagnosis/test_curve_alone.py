"""A stage whose ceramic has a curve and no hysteresis: neither its sensor nor its noise is taken for memory."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from numpy.typing import NDArray

from fixtures.linear_stage import LAG, LINEAR, SAMPLES, T_S, scene
from hysgen.diagnosis import search
from hysgen.diagnosis.probe import Mode, Scene, Trace, linear_fit, refine
from hysgen.diagnosis.probe.chain import respond
from hysgen.diagnosis.procedure import name_causes
from hysgen.diagnosis.score import Scored, present
from hysgen.model.disturbances.coupling import Coupling
from hysgen.model.path.modes import Modes
from hysgen.record import Record
from hysgen_lab.stage import NoiseEffect, Stage
from hysgen_lab.stage import run as measure
from hysgen_lab.stage.effects.memory import draw_curve
from hysgen_lab.studies.bank.excitation import good

Floats = NDArray[np.float64]

TIMES_S, ROWS = 1e-3, 7000
STAGE = Stage(stroke_um=15.0, lag_s=30e-3)
BENT = dataclasses.replace(STAGE, noise=NoiseEffect(2e-4))
FLICKERING = dataclasses.replace(STAGE, lag_s=8e-3, noise=NoiseEffect(5e-3, 2.5e-3))


def names(stage: Stage, bend: float, seed: int) -> tuple[str, ...]:
    """The causes of a stage with a curve. bend: of the sensor, c of y + c s (1 - s) span, s = (y - low) / span."""
    u_V = good(np.random.default_rng([seed, 77]), ROWS, 0.0, 100.0)
    curve = draw_curve(np.random.default_rng(seed), stage.stroke_um)
    y_um = measure(dataclasses.replace(stage, memory=curve), u_V, TIMES_S, seed).displacement_um
    share = (y_um - y_um.min()) / np.ptp(y_um)
    return name_causes(Record.from_arrays(u_V, y_um + bend * np.ptp(y_um) * share * (1.0 - share), TIMES_S)).names


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize(("stage", "bend"), [(BENT, 0.02), (FLICKERING, 0.0)], ids=["curved sensor", "1/f noise"])
@pytest.mark.slow
def test_no_cause_is_named(stage: Stage, bend: float, seed: int) -> None:
    assert names(stage, bend, seed) == ()


@pytest.mark.slow
def test_weights_that_fit_coloured_noise_are_no_evidence() -> None:
    """A channel that has nothing to do with the stage, as slow as the noise, over 32 samples."""
    rng = np.random.default_rng(3)
    slow = np.exp(-np.arange(200) / 40.0)

    def wandering() -> Floats:
        return np.convolve(rng.normal(size=SAMPLES), slow)[:SAMPLES]

    seen = scene(LAG, 2e-4 * wandering(), {"axis2_V": wandering()})
    with_taps = LAG.having(Coupling.of({"axis2_V": (-1e3, 1e3)}, 32))
    larger, smaller = (Scored.of(seen, refine(seen, chain)) for chain in (with_taps, LAG))
    assert larger.fall_from(smaller, left_out=True) < larger.fall_from(smaller)
    assert "coupling" not in present(search.search(seen).fit.chain)


def test_a_mode_that_rings_from_a_movement_before_the_record_is_found_as_it_is() -> None:
    mode = Mode(22.0, 0.02, 0.1)
    left_um = 0.5 * np.exp(-2.0 * np.pi * mode.f_Hz * mode.zeta * T_S) * np.cos(2.0 * np.pi * mode.f_Hz * T_S + 1.0)
    seen = scene(LAG.having(Modes.of((mode,), 1.0)), left_um)
    fit = refine(seen, LAG.having(Modes.of((Mode(24.0, 0.05, 0.2),), 1.0)))
    found = fit.chain.of(Modes).modes[0]
    assert fit.rms_um < 1.1e-3
    assert found.zeta == pytest.approx(mode.zeta, rel=0.01)
    assert found.share == pytest.approx(mode.share, rel=0.01)


def test_a_curve_of_the_sensor_that_few_samples_show_is_not_extrapolated() -> None:
    """A slow command with one step, which the fitted rows do not hold: at the step the fit predicts no other curve."""
    t_s = 1e-3 * np.arange(20_000)
    u_V = 50.0 + 40.0 * np.sin(0.4 * t_s) * np.where(t_s > 10.0, -1.0, 1.0)
    y_um = 0.1 * respond(u_V, LAG, 1e-3) + 1e-3 * np.random.default_rng(8).normal(size=len(t_s))
    rows = np.concatenate([np.arange(50, 9_990), np.arange(10_200, len(t_s))])
    seen = Scene((Trace(u_V, y_um, {}),), 1e-3, rows, LINEAR)
    assert np.abs(linear_fit(seen, LAG).error[50:]).max() < 0.03
