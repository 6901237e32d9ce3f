"""Noise while the stage rests: a vibration is no misfit of the hysteresis, and memory beside it is found."""

from __future__ import annotations

import numpy as np
import pytest

from fixtures.linear_stage import COMMAND_V, LAG, NOISE_UM, SAMPLES, T_S, TS_S, scene
from hysgen.diagnosis.probe import refine, rms
from hysgen.diagnosis.probe.chain import respond
from hysgen.diagnosis.procedure import name_causes
from hysgen.diagnosis.score import resting_noise
from hysgen.record import Record
from hysgen_lab.stage import Density, NoiseEffect, Relays, Stage
from hysgen_lab.stage import run as measure
from hysgen_lab.stage.effects.chirp import ChirpEffect
from hysgen_lab.stage.effects.memory import Hysteresis, draw_curve
from hysgen_lab.studies.bank.excitation import good
from hysgen_lab.studies.bank.scenario import ACCEPTED

RATE_S, ROWS = 1e-3, 7000
NARROW = Relays(Density(40.0, 55.0, 15.0, 65.0), 0.15)
VIBRATION = ChirpEffect(first_Hz=5.0, last_Hz=20.0, over_s=RATE_S * ROWS, amplitude_um=0.4)


def stage(hysteresis: Hysteresis) -> Stage:
    return Stage(stroke_um=15.0, lag_s=8e-3, memory=hysteresis, noise=NoiseEffect(5e-4))


def names(measured: Stage, seed: int) -> set[str]:
    u_V = good(np.random.default_rng([seed, 77]), ROWS, 0.0, 100.0)
    y_um = measure(measured, u_V, RATE_S, seed).displacement_um
    return set(name_causes(Record.from_arrays(u_V, y_um, RATE_S, accept=ACCEPTED)).names)


def test_a_vibration_is_noise_while_the_stage_rests_and_a_misfit_is_not() -> None:
    """The misfit: 0.2 um of a sine of the voltage, which the curve of the operator cannot follow."""
    shaken = scene(LAG, 0.05 * np.sin(2.0 * np.pi * 17.0 * T_S))
    bent = scene(LAG, 0.2 * respond(np.sin(0.4 * np.pi * COMMAND_V), LAG, TS_S))
    assert resting_noise(shaken, refine(shaken, LAG)) == pytest.approx(0.05 / np.sqrt(2.0), rel=0.1)
    assert rms(refine(bent, LAG).error) > 0.05
    assert resting_noise(bent, refine(bent, LAG)) == pytest.approx(NOISE_UM, rel=0.2)


def test_corrupted_samples_are_no_noise() -> None:
    spikes_um = np.where(np.arange(SAMPLES) % 50 == 0, 5.0, 0.0)
    spiked = scene(LAG, spikes_um)
    spiked = spiked.using(spiked.rows[spikes_um[spiked.rows] == 0.0])
    assert resting_noise(spiked, refine(spiked, LAG)) == pytest.approx(NOISE_UM, rel=0.1)


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.slow
def test_memory_is_named_beside_a_vibration_of_changing_frequency(seed: int) -> None:
    curve = draw_curve(np.random.default_rng(seed), 15.0)
    assert names(stage(curve).with_effects(chirp=VIBRATION), seed) == {"unknown"}
    assert names(stage(NARROW).with_effects(chirp=VIBRATION), seed) == {"memory", "unknown"}
