"""A mode whose frequency falls with amplitude is named, extended and priced; any other is a resonance alone."""

from __future__ import annotations

import numpy as np
import pytest

from hysgen.diagnosis import DiagnoseSettings, diagnose
from hysgen.diagnosis.procedure import name_causes
from hysgen.model.path.loop import Loop
from hysgen.record import Record
from hysgen.report.words import price_of
from hysgen_lab.stage import ResonanceEffect, Stage, run
from hysgen_lab.stage.effects.softening import SofteningEffect

TS_S, F_HZ = 1e-4, 300.0


def record(stage: Stage, seed: int, samples: int) -> Record:
    """Lines about the mode, at a level that changes every 500 samples."""
    rng = np.random.default_rng(seed)
    lines_Hz = np.arange(20.0, 2.2 * F_HZ, 6.0) + rng.uniform(-2.0, 2.0, 107)
    phases = 2.0 * np.pi * (lines_Hz[:, None] * TS_S * np.arange(samples) + rng.uniform(0.0, 1.0, (107, 1)))
    level = np.repeat(rng.uniform(0.3, 1.0, samples // 500 + 1), 500)[:samples]
    u_V = 50.0 + level * np.cos(phases).sum(axis=0)
    return Record.from_arrays(u_V, run(stage, u_V, TS_S, rest_V=50.0).displacement_um, fs_Hz=1.0 / TS_S)


STILL = Stage(lag_s=2e-5, memory=None)


@pytest.mark.slow
def test_memory_in_the_loop_of_a_mode_is_named_extended_and_priced() -> None:
    """Iwan's elements in the plant, Duhem states in the model."""
    stage = STILL.with_effects(softening=SofteningEffect(F_HZ, 0.02, yielding=0.5, yield_V=8.0))
    found = diagnose(record(stage, 1, 8000), record(stage, 2, 4000), DiagnoseSettings(price=price_of))
    assert found.names == ("resonance", "softening")
    cause = found.causes[1]
    # Two states stand for a continuum of elements: the smallest amplitudes are theirs to 3 %.
    assert cause.parameters["small_f_Hz"].value == pytest.approx(F_HZ, rel=0.05)
    assert cause.parameters["f_Hz"].value < 0.8 * F_HZ
    assert cause.price is not None
    assert (cause.price.cycles or 0) > 100
    assert found.extended_rms_um < 0.05 * found.base_rms_um
    loop = found.model.blocks[-1]
    assert isinstance(loop, Loop)
    assert _last_step_um(loop) < 1e-3 * min(loop.box_um)


@pytest.mark.slow
def test_a_mode_of_one_frequency_is_a_resonance_alone() -> None:
    mode = STILL.with_effects(resonance=ResonanceEffect(F_HZ, 0.02, 1.0))
    assert name_causes(record(mode, 1, 8000)).names == ("resonance",)


def _last_step_um(loop: Loop) -> float:
    """Largest step after 0.6 s at constant input from 1000 random states of the box: no certificate says it settles."""
    rng, still = np.random.default_rng(4), np.zeros(1000, dtype=np.float32)
    mirror = loop.mirror(still, TS_S)
    mirror.position, mirror.velocity, *mirror.h = (
        rng.uniform(-1.0, 1.0, (2 + len(loop.box_um), still.size))
        * np.array([[loop.box_um[0]] * 2 + list(loop.box_um)]).T
    ).astype(np.float32)
    for _ in range(6000):
        before = mirror.position
        mirror.apply(still)
    return float(np.abs(mirror.position - before).max())
